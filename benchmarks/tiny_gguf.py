"""Makes a language model of random weights as a GGUF file of a megabyte, for real servers of llama.cpp.

    python benchmarks/tiny_gguf.py FILE

Its replies are noise, the same for the same seed. Needs the packages gguf and tokenizers.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

WIDTH, LAYERS, HEADS, KEY_HEADS, TOKENS, CONTEXT = 64, 2, 4, 2, 2000, 8192
SPECIAL = ("<|endoftext|>", "<|im_start|>", "<|im_end|>")
CHAT = (
    "{% for m in messages %}<|im_start|>{{ m['role'] }}\n{{ m['content'] }}<|im_end|>\n{% endfor %}"
    "{% if add_generation_prompt %}<|im_start|>assistant\n{% endif %}"
)


def vocabulary(text: str) -> dict[str, Any]:
    """Return a byte-level BPE tokenizer trained on a text, as tokenizers writes it down."""
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


def write(path: Path, seed: int = 0) -> None:
    """Write the model."""
    import gguf

    words = vocabulary(Path(__file__).read_text(encoding="utf-8"))
    writer = gguf.GGUFWriter(str(path), "qwen2")
    _write_shape(writer, len(words["vocab"]))
    _write_words(writer, words)
    rng = np.random.default_rng(seed)
    for name, tensor in _tensors(rng, len(words["vocab"])):
        writer.add_tensor(name, tensor)
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()


def _write_shape(writer: Any, tokens: int) -> None:
    writer.add_name("tiny-random")
    writer.add_context_length(CONTEXT)
    writer.add_embedding_length(WIDTH)
    writer.add_block_count(LAYERS)
    writer.add_feed_forward_length(2 * WIDTH)
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
    writer.add_token_types([gguf.TokenType.CONTROL if one in SPECIAL else gguf.TokenType.NORMAL for one in in_order])
    writer.add_token_merges([one if isinstance(one, str) else " ".join(one) for one in words["merges"]])
    writer.add_eos_token_id(words["vocab"]["<|im_end|>"])
    writer.add_chat_template(CHAT)


def _tensors(rng: np.random.Generator, tokens: int) -> list[tuple[str, Any]]:
    """Return all tensors by name; the scale of the last one makes replies vary."""

    def drawn(*shape: int, scale: float = 0.1) -> Any:
        return rng.normal(0, scale, shape).astype(np.float32)

    found = [
        ("token_embd.weight", drawn(tokens, WIDTH, scale=1.0)),
        ("output_norm.weight", np.ones(WIDTH, np.float32)),
        ("output.weight", drawn(tokens, WIDTH, scale=2.4 / WIDTH**0.5)),
    ]
    keys = WIDTH * KEY_HEADS // HEADS
    for layer in range(LAYERS):
        prefix = f"blk.{layer}."
        found += [(f"{prefix}{name}_norm.weight", np.ones(WIDTH, np.float32)) for name in ("attn", "ffn")]
        for name, out in (("q", WIDTH), ("k", keys), ("v", keys)):
            found += [(f"{prefix}attn_{name}.weight", drawn(out, WIDTH)), (f"{prefix}attn_{name}.bias", drawn(out))]
        found.append((f"{prefix}attn_output.weight", drawn(WIDTH, WIDTH)))
        found += [(f"{prefix}ffn_{name}.weight", drawn(2 * WIDTH, WIDTH)) for name in ("gate", "up")]
        found.append((f"{prefix}ffn_down.weight", drawn(WIDTH, 2 * WIDTH)))
    return found


if __name__ == "__main__":
    write(Path(sys.argv[1]))
