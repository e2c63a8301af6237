"""Makes a language model with random weights as a GGUF file of a megabyte, for real servers of llama.cpp.

    python benchmarks/tiny_gguf.py FILE [--seed 0] [--width 64] [--moved 0.0] [--type F32] [--words go,stay]

The replies are noise; equal seeds give equal replies. You can move each weight by a share of itself, and quantise the
matrices; at a width of 128, a server can also quantise caches. With --words, a reply is one of these words, with
probabilities that depend on the prompt. Needs the packages gguf and tokenizers.
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

LAYERS, HEADS, KEY_HEADS, TOKENS, CONTEXT = 2, 4, 2, 2000, 8192
SPECIAL = ("<|endoftext|>", "<|im_start|>", "<|im_end|>")
CHAT = (
    "{% for m in messages %}<|im_start|>{{ m['role'] }}\n{{ m['content'] }}<|im_end|>\n{% endfor %}"
    "{% if add_generation_prompt %}<|im_start|>assistant\n{% endif %}"
)


def vocabulary(text: str) -> dict[str, Any]:
    """Return a byte-level BPE tokenizer that was trained on a text, in the JSON form of the package tokenizers."""
    from tokenizers import Tokenizer, models, pre_tokenizers, trainers

    tokenizer = Tokenizer(models.BPE())
    tokenizer.pre_tokenizer = pre_tokenizers.ByteLevel(add_prefix_space=False)
    alphabet = pre_tokenizers.ByteLevel.alphabet()
    trainer = trainers.BpeTrainer(
        vocab_size=TOKENS, special_tokens=list(SPECIAL), initial_alphabet=alphabet, show_progress=False
    )
    tokenizer.train_from_iterator([text], trainer)
    written: dict[str, Any] = json.loads(tokenizer.to_str())
    return written["model"]


def write(
    path: Path, *, seed: int = 0, width: int = 64, moved: float = 0.0, kind: str = "F32", saying: Sequence[str] = ()
) -> None:
    """Write the model with the weights of a seed, each moved by a share of itself, in a type such as Q8_0."""
    import gguf

    quantised = gguf.GGMLQuantizationType[kind]
    said = "\n".join([""] + [*saying] * 99)
    words = vocabulary(Path(__file__).read_text(encoding="utf-8") + said)
    writer = gguf.GGUFWriter(str(path), "qwen2")
    _write_shape(writer, len(words["vocab"]), width)
    _write_words(writer, words)
    rng, moves = np.random.default_rng(seed), np.random.default_rng(seed + 1)
    for name, tensor in _tensors(rng, len(words["vocab"]), width):
        if saying:
            _lean(name, tensor, [words["vocab"][word] for word in saying], words["vocab"]["<|im_end|>"])
        if tensor.ndim == 1:
            writer.add_tensor(name, tensor)
            continue
        tensor = (tensor * (1 + moved * moves.normal(size=tensor.shape))).astype(np.float32)
        writer.add_tensor(name, gguf.quants.quantize(tensor, quantised), raw_dtype=quantised)
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()


def _lean(name: str, tensor: Any, words: list[int], end: int) -> None:
    """Make the words the likeliest tokens after all other tokens, and the end the likeliest token after a word.

    Component 0 is the same in every state, and component 1 marks words; the last layer reads both components.
    """
    if name == "token_embd.weight":
        tensor[:, :2] = [16.0, 0.0]
        tensor[words, 1] = 60.0
    elif name == "output.weight":
        tensor[:, :2] = 0.0
        tensor[words, 0], tensor[end, 1] = 4.0, 4.0
    elif name.endswith(("attn_output.weight", "ffn_down.weight")):
        tensor *= 2.0
        tensor[:2] = 0.0


def _write_shape(writer: Any, tokens: int, width: int) -> None:
    writer.add_name("tiny-random")
    writer.add_context_length(CONTEXT)
    writer.add_embedding_length(width)
    writer.add_block_count(LAYERS)
    writer.add_feed_forward_length(2 * width)
    writer.add_head_count(HEADS)
    writer.add_head_count_kv(KEY_HEADS)
    writer.add_layer_norm_rms_eps(1e-6)
    writer.add_vocab_size(tokens)


def _write_words(writer: Any, words: dict[str, Any]) -> None:
    import gguf

    in_order = sorted(words["vocab"], key=words["vocab"].__getitem__)
    writer.add_tokenizer_model("gpt2")
    writer.add_tokenizer_pre("qwen2")
    writer.add_token_list(in_order)
    writer.add_token_types([gguf.TokenType.CONTROL if word in SPECIAL else gguf.TokenType.NORMAL for word in in_order])
    writer.add_token_merges([word if isinstance(word, str) else " ".join(word) for word in words["merges"]])
    writer.add_eos_token_id(words["vocab"]["<|im_end|>"])
    writer.add_chat_template(CHAT)


def _tensors(rng: np.random.Generator, tokens: int, width: int) -> list[tuple[str, Any]]:
    """Return all tensors by name; the scale of the last tensor makes replies different."""

    def drawn(*shape: int, scale: float = 0.1) -> Any:
        return rng.normal(0, scale, shape).astype(np.float32)

    arrays = [
        ("token_embd.weight", drawn(tokens, width, scale=1.0)),
        ("output_norm.weight", np.ones(width, np.float32)),
        ("output.weight", drawn(tokens, width, scale=2.4 / width**0.5)),
    ]
    keys = width * KEY_HEADS // HEADS
    for layer in range(LAYERS):
        prefix = f"blk.{layer}."
        arrays += [(f"{prefix}{name}_norm.weight", np.ones(width, np.float32)) for name in ("attn", "ffn")]
        for name, out in (("q", width), ("k", keys), ("v", keys)):
            arrays += [(f"{prefix}attn_{name}.weight", drawn(out, width)), (f"{prefix}attn_{name}.bias", drawn(out))]
        arrays.append((f"{prefix}attn_output.weight", drawn(width, width)))
        arrays += [(f"{prefix}ffn_{name}.weight", drawn(2 * width, width)) for name in ("gate", "up")]
        arrays.append((f"{prefix}ffn_down.weight", drawn(width, 2 * width)))
    return arrays


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--width", type=int, default=64)
    parser.add_argument("--moved", type=float, default=0.0)
    parser.add_argument("--type", default="F32")
    parser.add_argument("--words", default="")
    asked = parser.parse_args()
    saying = [word for word in asked.words.split(",") if word]
    write(asked.file, seed=asked.seed, width=asked.width, moved=asked.moved, kind=asked.type, saying=saying)
