"""Measures on llama.cpp servers how well a canary identifies weights, and whether log-probabilities predict decisions.

FOUNDRY_LLAMA_PYTHON names a Python with the packages xllamacpp, gguf and tokenizers; without it, nothing is measured.
FOUNDRY_LLAMA_PYTHON_OLD may name another Python with an older xllamacpp.
"""

import asyncio
import contextlib
import math
import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from measuring import ROOT, await_health, print_table, print_title, scratch

from foundry.canary import LIKELIEST, PROMPTS, Distance, Sign
from foundry.composing.compose import compose
from foundry.errors import ModelChangedError
from foundry.models.answers.sqlite import SqliteAnswers
from foundry.models.base import ChatMessage, Model, Request
from foundry.models.wrappers.canaries import CanaryAsker
from foundry.models.wrappers.confirmed import CONFIRM_EVERY_CALLS
from foundry.running.build import build, model_stack
from foundry.seeding import stream

PYTHON, OLD = "FOUNDRY_LLAMA_PYTHON", "FOUNDRY_LLAMA_PYTHON_OLD"
PORT = 8097
URL = f"http://127.0.0.1:{PORT}"
FULL = ("--slots", "4", "--context", "4096", "--threads", "1")
SHAPE = ("--width", "128")
SAMPLES = 2_000
PART = "\N{REPLACEMENT CHARACTER}"
EMPTY = (Sign(text=""),) * len(PROMPTS)


@dataclass(frozen=True)
class Case:
    """A server that is compared with the first one: the options of its model, its flags, and its Python."""

    name: str
    made: tuple[str, ...] = ()
    flags: tuple[str, ...] = FULL
    python: str = PYTHON
    beside: int = 0


CASES = (
    Case("same weights, same flags, started again"),
    Case("same weights, asked beside 8 other calls", beside=8),
    Case("same weights, 1 slot, half the context", flags=("--slots", "1", "--context", "2048")),
    Case("same weights, 2 threads, batches of 64", flags=("--threads", "2", "--batch", "64")),
    Case("same weights, cache of Q8_0", flags=(*FULL, "--cache", "Q8_0")),
    Case("same weights, cache of Q4_0", flags=(*FULL, "--cache", "Q4_0")),
    Case("same weights, server of September", python=OLD),
    Case("weights in F16", ("--type", "F16")),
    Case("weights in Q8_0", ("--type", "Q8_0")),
    Case("weights in Q4_0", ("--type", "Q4_0")),
    Case("each weight moved by 1 %", ("--moved", "0.01")),
    Case("each weight moved by 10 %", ("--moved", "0.1")),
    Case("other weights of the same shape", ("--seed", "1")),
)


def made(folder: Path, options: Sequence[str]) -> Path:
    """Return the file of a model with these options; each model is made once."""
    model = folder / f"tiny{'_'.join(options)}.gguf"
    if not model.exists():
        maker = ROOT / "benchmarks" / "tiny_gguf.py"
        subprocess.run([os.environ[PYTHON], str(maker), str(model), *SHAPE, *options], check=True)
    return model


@contextlib.contextmanager
def serving(model: Path, flags: Sequence[str] = FULL, python: str = PYTHON) -> Iterator[None]:
    """Run a server."""
    program = [os.environ[python], str(ROOT / "tests" / "servers" / "llama_server.py"), str(model), str(PORT), *flags]
    silent = subprocess.DEVNULL
    with subprocess.Popen(program, stdout=silent, stderr=silent) as process:
        try:
            await_health(process, URL)
            yield
        finally:
            process.kill()


def model_of(*settings: str) -> Model:
    """Return the model of the server with the shipped settings, except for these settings and shorter replies."""
    served = f"model.server.base_url={URL}/v1"
    composed = compose(
        ["model=openai/tiny", served, "model.server.canary=true", "model.options.max_tokens=60", *settings]
    )
    assert composed is not None
    model: Model = build(composed.conditions[0].config["model"])
    return model


def request(number: int, seed: int = 0) -> Request:
    """Return a call like the calls of agents."""
    message = ChatMessage("user", f"You are agent {number}. " + "A fire is near, people walk north. " * 20)
    return Request((message,), seed, "action", {}, 1, number, key=str(number))


async def canary(beside: int = 0) -> tuple[Sign, ...]:
    """Ask the canary, together with a number of other calls."""
    model = model_of()
    try:
        others = [asyncio.create_task(model.ask(request(number))) for number in range(beside)]
        replies = await CanaryAsker(model).ask()
        await asyncio.gather(*others)
        return replies[0] if replies else EMPTY
    finally:
        await model.close()


async def swapped(folder: Path, first: Path, other: Path) -> str:
    """Make calls to a server whose weights change and change back by restarts; return the call that notices it."""
    model, number = model_of(), 0
    with contextlib.closing(SqliteAnswers(folder / "swapped.sqlite")) as answers:
        with serving(first):
            stack = model_stack(model, lambda: answers, await model.inspect())
            for number in range(20):
                await stack.ask(request(number))
        try:
            with serving(other):
                for number in range(20, 60):
                    await stack.ask(request(number))
        except ModelChangedError:
            return f"found at foreign call {number - 19}"
        finally:
            await model.close()
    return "not found"


async def cost() -> tuple[int, float, float]:
    """Return the calls of a canary, its seconds, and the seconds of the same number of calls of a sweep."""
    model = model_of()
    try:
        await model.ask(request(0))
        asker, begun = CanaryAsker(model), time.perf_counter()
        await asker.ask()
        between = time.perf_counter()
        for number in range(asker.calls):
            await model.ask(request(number))
        return asker.calls, between - begun, time.perf_counter() - between
    finally:
        await model.close()


async def sampled() -> list[list[str]]:
    """Return the probabilities of the likeliest first tokens: reported by one call, and counted in samples."""
    plain = ("model.options.temperature=1", "model.options.top_p=1", "+model.extra.top_k=0", "+model.extra.min_p=0")
    model = model_of(*plain, "model.options.max_tokens=1", f"model.logprobs={LIKELIEST}")
    seeds = stream(0, "samples").integers(2**31, size=SAMPLES).tolist()
    try:
        replies = [await model.ask(request(0, seed)) for seed in seeds]
    finally:
        await model.close()
    logprobs = replies[0].logprobs[0].top
    counts = Counter(reply.logprobs[0].token for reply in replies if reply.logprobs)
    rows = []
    for token, logprob in logprobs.items():
        if PART in token:  # several tokens are shown so
            continue
        share, probability = counts[token] / SAMPLES, math.exp(logprob)
        half = 1.96 * math.sqrt(probability * (1 - probability) / SAMPLES)
        rows.append([repr(token), f"{probability:.3f}", f"{share:.3f}", f"{half:.3f}"])
    return rows


def met(foreign: int, draws: int = 20_000) -> float:
    """Return how often a canary falls among a number of calls in a row to other weights, with the draws of sweeps."""
    rng = stream(0, "benchmark")
    hits = 0
    for _ in range(draws):
        start = int(rng.integers(CONFIRM_EVERY_CALLS))
        blocks = range(start // CONFIRM_EVERY_CALLS, (start + foreign - 1) // CONFIRM_EVERY_CALLS + 1)
        places = [
            block * CONFIRM_EVERY_CALLS + int(stream(int(rng.integers(2**31)), "canary").integers(CONFIRM_EVERY_CALLS))
            for block in blocks
        ]
        hits += any(start <= place < start + foreign for place in places)
    return hits / draws


def row(case: Case, then: Sequence[Sign], now: Sequence[Sign]) -> list[str]:
    """Return the verdict about one server, from log-probabilities and from texts alone."""
    distance = Distance.between(then, now)
    texts = Distance.between(*([Sign(text=sign.text) for sign in signs] for signs in (then, now)))
    gap = "-" if distance.gap is None else f"{distance.gap:.4f}"
    return [case.name, gap, f"{distance.shared or 0:.0%}", distance.verdict, f"{texts.text:.0%}", texts.verdict]


def main() -> None:
    if PYTHON not in os.environ:
        sys.stdout.write(f"Canary: not measured, {PYTHON} names no Python.\n")
        return
    print_title("Canaries of llama.cpp servers", "A random model of width 128, compared with its first server.")
    with scratch() as folder:
        first = made(folder, ())
        with serving(first):
            then = asyncio.run(canary())
            calls, canary_s, sweep_s = asyncio.run(cost())
            samples = asyncio.run(sampled())
        rows = []
        for case in (case for case in CASES if case.python in os.environ):
            with serving(made(folder, case.made), case.flags, case.python):
                rows.append(row(case, then, asyncio.run(canary(case.beside))))
        print_table(["server", "gap", "shared", "verdict", "texts", "by texts"], rows)
        restarted = asyncio.run(swapped(folder, first, made(folder, ("--seed", "1"))))
    print_table(
        ["weights that change and change back", "found"],
        [
            ["by a restart of the server", restarted],
            *([f"{number} calls behind an open connection", f"{met(number):.2f}"] for number in (40, 100, 200)),
        ],
    )
    print_table(["first token", "probability by one call", f"share of {SAMPLES} samples", "half interval"], samples)
    sys.stdout.write(f"\nA canary: {calls} calls, {canary_s:.2f} s; as many calls of a sweep take {sweep_s:.2f} s.\n")


if __name__ == "__main__":
    main()
