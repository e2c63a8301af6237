"""Compares the limit on calls that foundry finds itself with fixed limits, on real servers of llama.cpp.

    python benchmarks/bench_limiter.py [--slots 1,4,8] [--minutes 10] [--block 20]

Four runs of twenty agents send calls at the same time, as in a sweep. The limits take turns in short blocks, so that a
machine that becomes slower favours no limit. foundry's own limit continues where its last block ended.
FOUNDRY_LLAMA_PYTHON names a Python with the packages xllamacpp, gguf and tokenizers, if this Python does not have them.
"""

import argparse
import asyncio
import contextlib
import itertools
import math
import os
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from measuring import ROOT, await_health, print_table, print_title, scratch

from foundry.composing.compose import compose
from foundry.models.base import ChatMessage, Model, Request
from foundry.models.serving import InFlight, serving_of
from foundry.models.wrappers.limited import Limit, LimitedModel
from foundry.models.wrappers.retried import RetriedModel
from foundry.running.build import build

PYTHON = os.environ.get("FOUNDRY_LLAMA_PYTHON", sys.executable)
AT_ONCE = 80
"""Number of questions that four runs of twenty agents ask at the same time."""
CONTEXT = 2048
LONGEST_REPLY = 200
STOP = "z"
"""Text that ends a reply of the random model, so that the replies have different lengths."""
SETTLED_S = 2.0
"""Seconds of a block before its measurement begins."""


@dataclass
class Contender:
    """A limit that takes turns with other limits.

    Attributes:
        bounds: lowest and highest limit; they are equal for a fixed limit.
        per_s: tokens per second in each block.
        limits: calls allowed in flight at the end of each block.
    """

    bounds: InFlight
    per_s: list[float] = field(default_factory=list)
    limits: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._before_s, self._began = 0.0, math.inf
        self._limit = Limit(self.bounds, clock=lambda: self._before_s + self._passed_s)

    @property
    def _passed_s(self) -> float:
        """Seconds of the present block; between blocks the limit's clock stands still."""
        return max(0.0, time.perf_counter() - self._began)

    async def take_turn(self, bare: Model, numbers: Iterator[int], seconds: float) -> None:
        """Send calls during a block, and record the throughput."""
        retried = RetriedModel(bare, serving_of(bare).retry, noted=self._limit.note_failure)
        model, tokens = LimitedModel(retried, self._limit), 0

        async def ask() -> None:
            nonlocal tokens
            while True:
                reply = await model.ask(request(next(numbers)))
                if self._passed_s >= SETTLED_S:
                    tokens += reply.output_tokens or 0

        self._began = time.perf_counter()
        agents = [asyncio.create_task(ask()) for _ in range(AT_ONCE)]
        ended, _ = await asyncio.wait(agents, timeout=seconds, return_when=asyncio.FIRST_EXCEPTION)
        self.per_s.append(tokens / (self._passed_s - SETTLED_S))
        for agent in agents:
            agent.cancel()
        await asyncio.gather(*agents, return_exceptions=True)
        self._before_s, self._began = self._before_s + self._passed_s, math.inf
        for agent in ended:  # by an error, since none ends of itself
            agent.result()
        self.limits.append(self._limit.allowed)


def model_at(url: str) -> Model:
    """Return the model of a server with the shipped settings, but with shorter replies."""
    composed = compose(
        [
            "model=openai/tiny",
            f"model.server.base_url={url}/v1",
            f"model.options.max_tokens={LONGEST_REPLY}",
            f"model.options.stop=['{STOP}']",
            "model.options.temperature=1",
        ]
    )
    assert composed is not None
    model: Model = build(composed.conditions[0].config["model"])
    return model


def request(number: int) -> Request:
    """Return a call that is not in any prompt cache."""
    text = f"You are agent {number}. " + "A fire is near, people walk north. " * 5
    return Request((ChatMessage("user", text),), number, "action", {}, 1, number, key=str(number))


@contextlib.contextmanager
def serving(slots: int, threads: int, width: int) -> Iterator[str]:
    """Run a server with a model of random weights on another core than the client, and yield its base URL."""
    with socket.socket() as free, scratch(in_memory=True) as folder:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
        free.close()
        model = str(folder / "tiny.gguf")
        maker = ROOT / "benchmarks" / "tiny_gguf.py"
        subprocess.run([PYTHON, str(maker), model, "--width", str(width)], check=True)
        flags = ("--slots", str(slots), "--context", str(CONTEXT), "--threads", str(threads), "--remembered", "0")
        program = [PYTHON, str(ROOT / "tests" / "servers" / "llama_server.py"), model, port, *flags]
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, cores[1:] or cores)  # the server inherits it
        with subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            os.sched_setaffinity(0, cores[:1])
            try:
                await_health(process, f"http://127.0.0.1:{port}")
                yield f"http://127.0.0.1:{port}"
            finally:
                process.kill()
                os.sched_setaffinity(0, cores)


async def compete(url: str, slots: int, seconds: float, block_s: float) -> tuple[Contender, dict[int, Contender]]:
    """Let foundry's limit and fixed limits take turns; each limit has every place in the order equally often."""
    model = model_at(url)
    info = await model.inspect()
    assert info.slots == slots
    own = Contender(serving_of(model).in_flight.from_slots(slots))
    fixed = {limit: Contender(InFlight(min=limit, max=limit, initial=limit)) for limit in tried(slots)}
    order, numbers = [own, *fixed.values()], itertools.count()
    for _ in range(max(2, round(seconds / block_s / len(order)))):
        for contender in order:
            await contender.take_turn(model, numbers, block_s)
        order.append(order.pop(0))
    await model.close()
    return own, fixed


def tried(slots: int) -> list[int]:
    """Return the fixed limits for the comparison."""
    return [slots, slots + 1, math.ceil(1.25 * slots) + 1]


def ratio(own: Contender, fixed: Contender) -> str:
    """Return foundry's throughput divided by that of a fixed limit, and the standard error over the rounds."""
    logs = [math.log(rate / other) for rate, other in zip(own.per_s, fixed.per_s, strict=True)]
    mean = math.exp(statistics.fmean(logs))
    return f"{mean:.3f} ± {mean * statistics.stdev(logs) / math.sqrt(len(logs)):.3f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--slots", default="1,4,8", help="of the servers")
    parser.add_argument("--minutes", type=float, default=10, help="of all servers together")
    parser.add_argument("--block", type=float, default=20, help="seconds of a limit before the next one's turn")
    parser.add_argument("--threads", type=int, default=1, help="of a server")
    parser.add_argument("--width", type=int, default=512, help="of the model")
    asked = parser.parse_args()
    if subprocess.run([PYTHON, "-c", "import gguf, tokenizers, xllamacpp"], stderr=subprocess.DEVNULL).returncode:
        sys.stdout.write(f"The limit on real servers: not measured, {PYTHON} has no xllamacpp, gguf and tokenizers.\n")
        return
    print_title(
        "The limit that foundry finds, on real servers of llama.cpp",
        f"A random model of width {asked.width}; limits take turns in blocks of {asked.block:g} s. Foundry's tokens",
        "per second, divided by those of a fixed limit in the same round: geometric mean and standard error.",
    )
    rows: list[Sequence[str]] = []
    numbers = [int(number) for number in asked.slots.split(",")]
    for slots in numbers:
        with serving(slots, asked.threads, asked.width) as url:
            own, fixed = asyncio.run(compete(url, slots, 60 * asked.minutes / len(numbers), asked.block))
        for limit, other in fixed.items():
            means = (f"{statistics.fmean(contender.per_s):.0f}" for contender in (own, other))
            rows.append([f"{slots}", f"{limit}", ratio(own, other), *means, " ".join(map(str, own.limits))])
    print_table(["slots", "fixed limit", "foundry over fixed", "foundry's tokens/s", "fixed", "foundry's limits"], rows)


if __name__ == "__main__":
    main()
