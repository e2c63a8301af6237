"""Measures the speed of batches with models in foundry's own process, and how often a reply depends on its batch.

The model has the shape of Llama and random weights: 365 million with `--width 1024 --layers 24`. The last layer is
scaled so that the likeliest of 262 tokens has a probability of about .8, as in a trained model. Needs
foundry-worlds[hf].
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch
from measuring import print_table, print_title, scratch
from transformers import LlamaConfig, LlamaForCausalLM

from foundry.models.base import ChatMessage, Reply, Request
from foundry.models.local.engine import Engine, device_of, quiet
from foundry.models.local.settings import Sampling
from foundry.seeding import stream

SAMPLING = Sampling(temperature=0.8, top_k=0, top_p=1.0, min_p=0.0, max_new_tokens=64)
SPREAD = 5.0  # of the logits


def make_model(folder: Path, width: int, layers: int) -> Path:
    """Save a model of random weights, and return its folder."""
    from tiny_models import CONTEXT, make_tokenizer

    tokenizer = make_tokenizer()
    torch.manual_seed(0)
    shape = {"hidden_size": width, "intermediate_size": 4 * width, "num_hidden_layers": layers}
    heads = {"num_attention_heads": max(width // 64, 1), "num_key_value_heads": max(width // 256, 1)}
    ends = {"eos_token_id": 1, "pad_token_id": 0, "bos_token_id": None}
    config = LlamaConfig(vocab_size=len(tokenizer), max_position_embeddings=CONTEXT, **shape, **heads, **ends)
    model = LlamaForCausalLM(config)
    with torch.no_grad():
        model.lm_head.weight *= SPREAD / (config.initializer_range * width**0.5)
    model.save_pretrained(folder)
    tokenizer.save_pretrained(folder)
    return folder


def requests(count: int) -> list[Request]:
    """Return prompts of 400 to 800 characters, each with its seed."""
    draws = stream(0, "prompts")
    texts = ["".join(map(chr, draws.integers(97, 123, draws.integers(400, 800)))) for _ in range(count)]
    return [Request((ChatMessage("user", text),), seed, "action", {}, 1, 0) for seed, text in enumerate(texts)]


def replies(engine: Engine, asked: Sequence[Request], size: int) -> tuple[list[str], float]:
    """Return the texts of all replies in batches of `size`, and the calls per second."""
    started = time.perf_counter()
    answers: list[Any] = [reply for at in range(0, len(asked), size) for reply in engine.answer(asked[at : at + size])]
    seconds = time.perf_counter() - started
    failed = [answer for answer in answers if not isinstance(answer, Reply)]
    if failed:
        raise failed[0]
    return [reply.text for reply in answers], len(asked) / seconds


def main() -> None:
    """Print a row for each data type and batch size."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--width", type=int, default=256)
    parser.add_argument("--layers", type=int, default=4)
    parser.add_argument("--calls", type=int, default=64)
    parser.add_argument("--sizes", type=int, nargs="+", default=[8, 32])
    parser.add_argument("--types", nargs="+", default=["float32", "bfloat16", "float16"])
    parser.add_argument("--device", default="auto")
    chosen = parser.parse_args()
    quiet()
    device = device_of(chosen.device)
    card = torch.cuda.get_device_name(device) if device.type == "cuda" else "CPU"
    asked, rows = requests(chosen.calls), []
    with scratch() as folder:
        weights = make_model(folder / "model", chosen.width, chosen.layers)
        millions = sum(file.stat().st_size for file in weights.glob("*.safetensors")) / 4e6
        for name in chosen.types:
            engine = Engine(weights, dtype=name, device=chosen.device, sampling=SAMPLING, template={})
            replies(engine, asked[:2], 1)  # the first calls load what later ones use
            alone, single = replies(engine, asked, 1)
            again, _ = replies(engine, asked, 1)
            rows.append([name, 1, f"{single:.2f}", "1.0", same(alone, again), same(alone, again)])
            for size in chosen.sizes:
                texts, rate = replies(engine, asked, size)
                repeated, _ = replies(engine, asked, size)
                rows.append(
                    [name, size, f"{rate:.2f}", f"{rate / single:.1f}", same(texts, repeated), same(alone, texts)]
                )
            engine.close()
    print_title(
        "Models in foundry's own process",
        f"{card}, {millions:,.0f} million random weights; {chosen.calls} prompts of 400 to 800 tokens, "
        f"replies of up to {SAMPLING.max_new_tokens} tokens, temperature {SAMPLING.temperature}.",
    )
    print_table(["type", "batch", "calls/s", "ratio", "texts equal when repeated", "texts equal to those alone"], rows)


def same(texts: Sequence[str], others: Sequence[str]) -> str:
    """Return the number of equal texts and the number of texts, such as "3 of 16"."""
    return f"{sum(map(str.__eq__, texts, others))} of {len(texts)}"


if __name__ == "__main__":
    main()
