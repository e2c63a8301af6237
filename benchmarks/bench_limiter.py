"""How near the limit that foundry finds itself comes to the best fixed limit, on real servers of llama.cpp.

    python benchmarks/bench_limiter.py [--slots 1,4,8] [--seconds 120] [--fixed-seconds 20] [--pin] [--together]

Four runs of twenty agents ask at once, as a sweep does. Each fixed limit is measured before and after the default, so
that a machine that becomes slower favours neither. FOUNDRY_LLAMA_PYTHON names a Python with the packages xllamacpp,
gguf and tokenizers, where this one does not have them. For ten minutes of a sweep: --seconds 600 --fixed-seconds 60.
"""

import argparse
import asyncio
import contextlib
import itertools
import multiprocessing
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field

from measuring import ROOT, await_health, print_table, print_title, scratch

from foundry.composing.compose import compose
from foundry.models.answers.sqlite import SqliteAnswers
from foundry.models.base import ChatMessage, Model, Request
from foundry.models.serving import InFlight
from foundry.models.wrappers.limited import Limit
from foundry.running.build import build, model_stack

PYTHON = os.environ.get("FOUNDRY_LLAMA_PYTHON", sys.executable)
RUNS, AGENTS = 4, 20
CONTEXT = 2048
LONGEST_REPLY = 200
STOP = "z"
"""Ends a reply of the random model, so that their lengths differ."""
SETTLED_S = 3.0
"""Seconds of a fixed limit before its measurement begins."""
FIRST_S = 30.0
"""Seconds whose throughput is told, too."""


@dataclass
class Load:
    """Calls of a sweep that never ends, each asked once.

    Attributes:
        ends: times of the answers, seconds since the load began.
        tokens: their output tokens.
        limits: limits on the calls in flight at these times.
    """

    numbers: Iterator[int]
    ends: list[float] = field(default_factory=list)
    tokens: list[int] = field(default_factory=list)
    limits: list[int] = field(default_factory=list)

    async def put(self, url: str, fixed: int | None, seconds: float) -> None:
        """Ask for so long, by a fixed limit or the one that foundry finds."""
        model, limits = model_at(url, fixed), list[Limit]()

        def limit(bounds: InFlight) -> Limit:
            limits.append(Limit(bounds))
            return limits[0]

        with scratch(in_memory=True) as folder, contextlib.closing(SqliteAnswers(folder / "answers.sqlite")) as answers:
            stack = model_stack(model, lambda: answers, await model.inspect(), limit)
            began = time.perf_counter()
            runs = [asyncio.create_task(self._run(stack, limits[0], began)) for _ in range(RUNS)]
            ended, _ = await asyncio.wait(runs, timeout=seconds, return_when=asyncio.FIRST_EXCEPTION)
            for run in runs:
                run.cancel()
            await asyncio.gather(*runs, return_exceptions=True)
            await model.close()
            for run in ended:  # by an error, since none ends of itself
                run.result()

    async def _run(self, model: Model, limit: Limit, began: float) -> None:
        """Have all agents asked at once, step after step."""
        while True:
            await asyncio.gather(*(self._ask(model, limit, began) for _ in range(AGENTS)))

    async def _ask(self, model: Model, limit: Limit, began: float) -> None:
        reply = await model.ask(request(next(self.numbers)))
        self.ends.append(time.perf_counter() - began)
        self.tokens.append(reply.output_tokens or 0)
        self.limits.append(limit.allowed)

    def per_s(self, start: float, end: float) -> float:
        """Return the tokens a second between two times, seconds: calls differ in length, which would add noise."""
        told = zip(self.ends, self.tokens, strict=True)
        return sum(tokens for at, tokens in told if start <= at < end) / (end - start)


def model_at(url: str, fixed: int | None) -> Model:
    """Return the model of a server with the shipped settings, but for shorter replies and a fixed limit, if any."""
    limit = [] if fixed is None else [f"model.server.in_flight={{min: {fixed}, max: {fixed}, initial: {fixed}}}"]
    composed = compose(
        [
            "model=openai/tiny",
            f"model.server.base_url={url}/v1",
            f"model.options.max_tokens={LONGEST_REPLY}",
            f"model.options.stop=['{STOP}']",
            "model.options.temperature=1",
            *limit,
        ]
    )
    assert composed is not None
    model: Model = build(composed.conditions[0].config["model"])
    return model


def request(number: int) -> Request:
    """Return a call that no prompt cache knows."""
    text = f"You are agent {number}. " + "A fire is near, people walk north. " * 5
    return Request((ChatMessage("user", text),), number, "action", {}, 1, number, key=str(number))


@contextlib.contextmanager
def serving(slots: int, threads: int, width: int, cores: Sequence[int]) -> Iterator[str]:
    """Run a server with a model of random weights, on these cores; yields its base URL."""
    with socket.socket() as free, scratch(in_memory=True) as folder:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
        free.close()
        model = str(folder / "tiny.gguf")
        maker = ROOT / "benchmarks" / "tiny_gguf.py"
        subprocess.run([PYTHON, str(maker), model, "--width", str(width)], check=True)
        flags = ("--slots", str(slots), "--context", str(CONTEXT), "--threads", str(threads), "--remembered", "0")
        program = [PYTHON, str(ROOT / "tests" / "servers" / "llama_server.py"), model, port, *flags]
        here = os.sched_getaffinity(0)
        os.sched_setaffinity(0, cores or here)  # the server inherits it
        with subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            os.sched_setaffinity(0, here)
            try:
                await_health(process, f"http://127.0.0.1:{port}")
                yield f"http://127.0.0.1:{port}"
            finally:
                process.kill()


def measure(slots: int, asked: argparse.Namespace, cores: Sequence[int]) -> list[str]:
    """Return the row of a server with so many slots; the client has the first core, the server the others."""
    if cores:
        os.sched_setaffinity(0, cores[:1])
    tried = sorted({slots, slots + 1, 2 * slots, 4 * slots})
    rates: dict[int, list[float]] = {limit: [] for limit in tried}
    numbers = itertools.count()
    with serving(slots, asked.threads, asked.width, cores[1:]) as url:

        def fix(limits: Sequence[int]) -> None:
            for limit in limits:
                load, seconds = Load(numbers), SETTLED_S + asked.fixed_seconds / 2
                asyncio.run(load.put(url, limit, seconds))
                rates[limit].append(load.per_s(SETTLED_S, seconds))

        fix(tried)
        found = Load(numbers)
        asyncio.run(found.put(url, None, asked.seconds))
        fix(tried[::-1])
    means = {limit: sum(both) / len(both) for limit, both in rates.items()}
    best = max(means, key=means.__getitem__)
    half_s, length = asked.seconds / 2, sum(found.tokens) / len(found.tokens)
    later = [limit for limit, at in zip(found.limits, found.ends, strict=True) if at >= half_s]
    spans = [(0.0, asked.seconds), (0.0, FIRST_S), (half_s, asked.seconds)]
    return [
        str(slots),
        ", ".join(f"{limit}: {' '.join(f'{rate / length:.2f}' for rate in rates[limit])}" for limit in tried),
        str(best),
        *(f"{found.per_s(*span) / means[best]:.3f}" for span in spans),
        " ".join(str(limit) for limit, _ in itertools.islice(itertools.groupby(found.limits), 12)),
        f"{min(later)} to {max(later)}",
        f"{length:.0f}",
    ]


def measure_all(slots: Sequence[int], asked: argparse.Namespace, cores: Sequence[int]) -> list[list[str]]:
    """Measure one server after the other, or all together, each on its share of the cores."""
    if not asked.together:
        return [measure(number, asked, cores) for number in slots]
    each = len(cores) // len(slots)
    with ProcessPoolExecutor(len(slots), mp_context=multiprocessing.get_context("spawn")) as pool:
        shares = [cores[place * each :][:each] for place in range(len(slots))]
        return list(pool.map(measure, slots, itertools.repeat(asked), shares))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--slots", default="1,4,8", help="of the servers")
    parser.add_argument("--seconds", type=float, default=120, help="of the limit that foundry finds")
    parser.add_argument("--fixed-seconds", type=float, default=20, help="of each fixed limit")
    parser.add_argument("--threads", type=int, default=1, help="of a server")
    parser.add_argument("--width", type=int, default=512, help="of the model")
    parser.add_argument("--pin", action="store_true", help="the client to one core, the server to the others")
    parser.add_argument("--together", action="store_true", help="all servers at once, each with a share of the cores")
    asked = parser.parse_args()
    if subprocess.run([PYTHON, "-c", "import gguf, tokenizers, xllamacpp"], stderr=subprocess.DEVNULL).returncode:
        sys.stdout.write(f"The limit on real servers: not measured, {PYTHON} has no xllamacpp, gguf and tokenizers.\n")
        return
    print_title(
        "The limit that foundry finds, on real servers of llama.cpp",
        f"A random model of width {asked.width}; {RUNS} runs of {AGENTS} agents ask for {asked.seconds:g} s.",
        "The share is of the throughput of the best fixed limit, in calls of average length.",
    )
    cores = sorted(os.sched_getaffinity(0)) if asked.pin or asked.together else []
    rows = measure_all([int(number) for number in asked.slots.split(",")], asked, cores)
    spans = ("share", f"in the first {FIRST_S:g} s", "in the second half")
    print_table(["slots", "calls/s by fixed limit", "best", *spans, "first limits", "later", "tokens a reply"], rows)


if __name__ == "__main__":
    main()
