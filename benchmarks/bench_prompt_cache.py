"""Prompt tokens that a server of llama.cpp works out, by layout of the prompt and order of the calls.

FOUNDRY_LLAMA_SERVER names the program `llama-server`; without it nothing is measured. The prompts are those of a run
whose agents walk at random, say forty words a step and remember as many.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import aiohttp
import numpy as np
from measuring import print_table, print_title, scratch
from numpy.random import Generator
from tiny_gguf import write

from foundry import seeding
from foundry.composing.compose import compose
from foundry.composing.preflight import prompt_of, scenario_of
from foundry.worlds.base import Answer, Question

PROGRAM = "FOUNDRY_LLAMA_SERVER"
AGENTS, STEPS, SLOTS, CONTEXT, PORT = 20, 4, 4, 4096, 8099
LAYOUTS = ("paper", "reordered", "paper_prefix")
URL = f"http://127.0.0.1:{PORT}"
SPOKEN = ("the", "fire", "is", "near", "people", "walk", "north", "quiet", "crowd", "saw", "moved", "stayed", "door")


@dataclass(frozen=True)
class Order:
    """How the calls of a phase are sent.

    Attributes:
        name: what it is called.
        by_text: whether equal beginnings follow each other.
        pinned: whether an agent keeps to one slot.
        first_alone: whether the first call of a phase is answered before the others are sent.
    """

    name: str
    by_text: bool = False
    pinned: bool = False
    first_alone: bool = False


ORDERS = (
    Order("as foundry sends them"),
    Order("by text", by_text=True),
    Order("an agent on one slot", pinned=True),
    Order("the first alone", first_alone=True),
)


@dataclass(frozen=True)
class Sent:
    """One call."""

    agent: int
    text: str


@dataclass
class Told:
    """What the server told of all calls."""

    tokens: int = 0
    computed: int = 0
    wall_s: float = 0.0
    replies: tuple[str, ...] = ()


def phases(layout: str) -> list[list[Sent]]:
    """Return the prompts of a run, those that are asked at once together."""
    composed = compose([f"prompt={layout}", "model=scripted/random", f"world.agents={AGENTS}", f"world.steps={STEPS}"])
    assert composed is not None
    config = {**composed.conditions[0].config, "seed": 0}
    prompt, world, rng = prompt_of(config), scenario_of(config).start(0), seeding.stream(0, "words")
    found = []
    while not world.finished:
        questions = world.pending()
        found.append([Sent(one.agent, prompt.render(one)[0].content) for one in questions])
        world.advance([wordy(one, rng) for one in questions])
    return found


def wordy(question: Question, rng: Generator) -> Answer:
    """Return an answer with many words, and a step in any direction."""
    text = " ".join(rng.choice(SPOKEN, 40).tolist())
    way = str(rng.choice(["up", "down", "left", "right"]))
    answers: Mapping[str, Any] = {
        "message": {"message": text, "reasoning": ""},
        "action": {"action": "move", "direction": way, "memory": text, "reasoning": ""},
    }
    return Answer(json.dumps(answers[question.kind]))


@contextlib.contextmanager
def serving(program: str, model: Path) -> Iterator[None]:
    """Run the server with a fresh cache."""
    settings = ["-np", str(SLOTS), "-c", str(SLOTS * CONTEXT), "-t", "1", "--port", str(PORT)]
    process = subprocess.Popen(
        [program, "-m", str(model), *settings], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        asyncio.run(until_ready())
        yield
    finally:
        process.terminate()
        process.wait()


async def until_ready() -> None:
    async with aiohttp.ClientSession() as session:
        for _ in range(600):
            with contextlib.suppress(aiohttp.ClientError):
                async with session.get(f"{URL}/health") as found:
                    if found.status == 200:
                        return
            await asyncio.sleep(0.1)
    raise RuntimeError("llama-server does not start")


async def send_all(rounds: Sequence[Sequence[Sent]], order: Order) -> Told:
    """Send all calls, as many at once as there are slots."""
    told, slots, began = Told(), asyncio.Semaphore(SLOTS), time.perf_counter()
    replies: list[str] = []
    async with aiohttp.ClientSession(connector=aiohttp.TCPConnector(limit=0)) as session:

        async def send(one: Sent) -> str:
            body = {
                "messages": [{"role": "user", "content": one.text}],
                "max_tokens": 20,
                "seed": 1,
                "cache_prompt": True,
            }
            pin = {"id_slot": one.agent % SLOTS} if order.pinned else {}
            async with slots, session.post(f"{URL}/v1/chat/completions", json=body | pin) as answer:
                said = await answer.json()
            told.tokens += said["usage"]["prompt_tokens"]
            told.computed += said["usage"]["prompt_tokens"] - said["usage"]["prompt_tokens_details"]["cached_tokens"]
            return str(said["choices"][0]["message"]["content"])

        for calls in rounds:
            ordered = sorted(calls, key=lambda one: one.text) if order.by_text else list(calls)
            alone = 1 if order.first_alone else 0
            found = {one.agent: await send(one) for one in ordered[:alone]}
            rest = await asyncio.gather(*map(send, ordered[alone:]))
            found |= {one.agent: text for one, text in zip(ordered[alone:], rest, strict=True)}
            replies += [found[one.agent] for one in calls]
    told.wall_s, told.replies = time.perf_counter() - began, tuple(replies)
    return told


def main() -> None:
    program = os.environ.get(PROGRAM)
    if program is None:
        sys.stdout.write(f"Prompt cache: not measured, {PROGRAM} names no llama-server.\n")
        return
    print_title(
        "Prompt cache of a llama.cpp server",
        f"{AGENTS} agents, {STEPS} steps, {SLOTS} slots, a fresh server for each row. Replies are compared with",
        "those of the layout's first row: a server that reuses its work may round otherwise.",
    )
    rows = []
    with scratch() as folder:
        model = folder / "tiny.gguf"
        write(model)
        for layout in LAYOUTS:
            rounds, first = phases(layout), None
            for order in ORDERS:
                with serving(program, model):
                    told = asyncio.run(send_all(rounds, order))
                first = first or told
                rows.append(row(layout, order, told, first))
    print_table(["prompt", "order", "prompt tokens", "computed", "share", "calls/s", "same replies"], rows)


def row(layout: str, order: Order, told: Told, first: Told) -> list[str]:
    same = np.mean([one == other for one, other in zip(told.replies, first.replies, strict=True)])
    rate, share = len(told.replies) / told.wall_s, told.computed / told.tokens
    return [layout, order.name, f"{told.tokens:,}", f"{told.computed:,}", f"{share:.2f}", f"{rate:.1f}", f"{same:.0%}"]


if __name__ == "__main__":
    main()
