"""Compares the limit on calls that foundry finds itself with the best fixed limit, on many simulated servers."""

import argparse
import asyncio
import math
from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from aiohttp import ClientSession
from measuring import Server, at_least, at_most, print_table, print_title, run_sweep, scratch, serving

AGENTS, STEPS = 20, 2
CALLS_PER_RUN = 2 * AGENTS * STEPS
LEAST_WINDOW = 40
"""Minimum number of calls over which a throughput is measured."""
AS_GOOD = 0.98
"""The best limit is the smallest one with this share of the largest throughput that was seen."""
TAIL = 0.9
"""Share of the calls that is measured; at the end of a sweep, too few calls are left to keep a server busy."""


@dataclass(frozen=True)
class Kind:
    """A kind of server.

    Attributes:
        name: name in the table.
        settings: settings of `slots_server.py`.
        tried: fixed limits; the best one is the baseline.
        calls: number of calls of the sweep in which foundry finds the limit.
        within: number of calls after which foundry must reach 80 % of the best throughput.
        speaks: API of the server.
    """

    name: str
    settings: str
    tried: tuple[int, ...]
    calls: int
    within: int
    speaks: str = "ollama"

    @property
    def mean_s(self) -> float:
        """Seconds of work per call, on average."""
        return float(dict(pair.split("=") for pair in self.settings.split())["--mean"])


def ollama(slots: int, mean_s: float, overhead: float, calls: int) -> Kind:
    tried = tuple(sorted({slots, slots + 1, math.ceil(1.25 * slots) + 1, 2 * slots}))
    settings = f"--slots={slots} --mean={mean_s} --overhead={overhead}"
    return Kind(f"Ollama, {slots} slots, {100 * overhead:.0f} % overhead", settings, tried, calls, 300)


def vllm(slots: int, mean_s: float, tried: tuple[int, ...], calls: int, within: int) -> Kind:
    settings = f"--slots={slots} --mean={mean_s} --spread=0.6 --growth=1"
    return Kind(f"like vLLM, {slots} slots", settings, tried, calls, within, "openai")


KINDS = (
    *(ollama(1, 0.05, overhead, 600) for overhead in (0, 0.02, 0.2)),
    *(ollama(4, 0.1, overhead, 1_500) for overhead in (0, 0.02, 0.2)),
    *(ollama(16, 0.25, overhead, 3_000) for overhead in (0, 0.02, 0.2)),
    vllm(64, 0.4, (48, 64, 80), 6_000, 600),
    vllm(256, 0.5, (192, 256, 320), 16_000, 1_500),
    Kind(
        "50 calls/s, then 429",
        "--slots=1000 --mean=0.6 --spread=0.4 --per-s=50",
        (24, 32, 40),
        3_000,
        300,
        "openai",
    ),
    Kind("slower beyond 24", "--slots=1000 --mean=0.4 --best=24", (16, 24, 32), 4_000, 300, "openai"),
    Kind("16 slots, then 4", "--slots=16 --mean=0.2 --then-slots=4 --then-after=2000", (), 5_000, 300, "openai"),
    Kind("4 slots, then 16", "--slots=4 --mean=0.2 --then-slots=16 --then-after=1000", (), 4_000, 300, "openai"),
)
CHANGED = {"16 slots, then 4": (2_000, (16, 18), (4, 5)), "4 slots, then 16": (1_000, (4, 5), (16, 18))}
"""Number of calls after which a server changes, and the fixed limits for the time before and after."""


@dataclass(frozen=True)
class Seen:
    """Calls that a server measured.

    Attributes:
        ends: time at which each call ended, seconds, shape (calls,).
        in_flight: calls in flight at these times, shape (calls,).
        queued: calls in the server's queue at these times, shape (calls,).
        work: work of each call, divided by the mean, shape (calls,).
        refused: number of refused calls.
    """

    ends: np.ndarray
    in_flight: np.ndarray
    queued: np.ndarray
    work: np.ndarray
    refused: int

    def per_s(self, start: float = 0.0) -> float:
        """Return the calls of average length per second, after the given share of the calls."""
        first, last = int(start * len(self.ends)), int(TAIL * len(self.ends)) - 1
        return float(self.work[first + 1 : last + 1].sum() / (self.ends[last] - self.ends[first]))

    def calls_until(self, per_s: float, window: int) -> int | None:
        """Return the number of calls after which a given number of calls came at this pace; None if they never did."""
        done = np.cumsum(self.work)
        paces = (done[window:] - done[:-window]) / (self.ends[window:] - self.ends[:-window])
        reached = np.flatnonzero(paces >= per_s)
        return int(reached[0]) + window if len(reached) else None

    def long_run(self) -> float:
        """Return the mean number of calls in flight over the time of the second half."""
        first, last = len(self.ends) // 2, int(TAIL * len(self.ends))
        passed = np.diff(self.ends[first:last])
        return float(np.sum(passed * self.in_flight[first + 1 : last]) / np.sum(passed))


async def _seen(url: str, mean_s: float) -> Seen:
    async with ClientSession() as session, session.get(f"{url}/stats") as response:
        content = msgspec.json.decode(await response.read())
    ends, in_flight, queued, work_s = (np.array(column) for column in zip(*content["ends"], strict=True))
    return Seen(ends, in_flight, queued, work_s / mean_s, content["refused"])


def asked(kind: Kind, calls: int, limit: int | None, workers: int | None, settings: str | None = None) -> Seen:
    """Run a sweep on a new server, with a fixed limit or without, and return the calls that the server measured."""
    with (
        serving("slots_server.py", f"--speaks={kind.speaks}", *(settings or kind.settings).split()) as to,
        scratch(in_memory=True) as folder,
    ):
        fixed = [] if limit is None else [f"model.server.in_flight={{min: {limit}, max: {limit}, initial: {limit}}}"]
        run_sweep(
            folder / "sweep",
            *_reached(kind, to),
            f"world.agents={AGENTS}",
            f"world.steps={STEPS}",
            f"seed=0-{math.ceil(calls / CALLS_PER_RUN) - 1}",
            "model.server.retry.attempts=12",  # a fixed limit that is too high is refused again and again
            f"runner.workers={'null' if workers is None else workers}",
            *fixed,
        )
        return asyncio.run(_seen(to.url, kind.mean_s))


def _reached(kind: Kind, to: Server) -> list[str]:
    if kind.speaks == "ollama":
        return [f"model.server.hosts='{to.url}'"]
    return ["model=openai/a", f"model.server.base_url='{to.url}/v1'", "model.server.api_key_env=null"]


def best_of(kind: Kind, tried: Sequence[int], settings: str | None = None) -> tuple[int, float]:
    """Return the best fixed limit for one worker, and its calls per second."""
    rates = {limit: asked(kind, kind.calls // 3, limit, 1, settings).per_s(0.2) for limit in tried}
    top = max(rates.values())
    return min(limit for limit, rate in rates.items() if rate >= AS_GOOD * top), top


@dataclass(frozen=True)
class Result:
    """Result of foundry on one kind of server.

    Attributes:
        best: the best fixed limit, and its calls per second.
        share: throughput from the first call on, divided by the throughput with the best fixed limit.
        later: the same share in the second half of the sweep.
        reached: number of calls until the share is 80 %; None if it never is.
        in_flight: mean number of calls in flight in the second half.
        queued: greatest number of calls in the server's queue.
        refused: calls that the server refused.
    """

    best: tuple[int, float]
    share: float
    later: float
    reached: int | None
    in_flight: float
    queued: int
    refused: int


def measure(kind: Kind, workers: int | None) -> Result:
    seen = asked(kind, kind.calls, None, workers)
    if kind.name in CHANGED:
        return measure_changed(kind, seen)
    best = best_of(kind, kind.tried)
    share, later = seen.per_s() / best[1], seen.per_s(0.5) / best[1]
    return _result(best, share, later, seen, seen.calls_until(0.8 * best[1], LEAST_WINDOW))


def measure_changed(kind: Kind, seen: Seen) -> Result:
    """Measure a server that changes; the baseline uses the best limit before the change and the best limit after it."""
    after, *limits = CHANGED[kind.name]
    slots = [limits[0][0], limits[1][0]]
    halves = [best_of(kind, tried, f"--slots={n} --mean=0.2") for n, tried in zip(slots, limits, strict=True)]
    calls = int(TAIL * len(seen.ends))
    ideal_s = after / halves[0][1] + (calls - after) / halves[1][1]
    share = ideal_s / (seen.ends[calls - 1] - seen.ends[0])
    later = Seen(seen.ends[after:], seen.in_flight[after:], seen.queued[after:], seen.work[after:], seen.refused)
    reached = later.calls_until(0.8 * halves[1][1], LEAST_WINDOW)
    return _result(halves[1], share, later.per_s(0.5) / halves[1][1], later, reached)


def _result(best: tuple[int, float], share: float, later: float, seen: Seen, reached: int | None) -> Result:
    return Result(best, share, later, reached, seen.long_run(), int(seen.queued.max()), seen.refused)


def row(kind: Kind, result: Result) -> list[str]:
    return [
        kind.name,
        f"{result.best[0]}",
        f"{result.best[1]:.1f}",
        f"{result.share:.2f}",
        f"{result.later:.2f}",
        "never" if result.reached is None else f"{result.reached:,}",
        f"{result.in_flight:.1f}",
        f"{result.in_flight / result.best[0]:.2f}",
        f"{result.queued}",
        f"{result.refused}",
    ]


def targets(kind: Kind, result: Result) -> list[Sequence[str]]:
    most = max(1.5, 1 + 1 / result.best[0])  # one call more than one is twice as many
    reached = math.inf if result.reached is None else result.reached
    return [
        [f"{kind.name}: share of the best fixed limit", f"{result.share:.2f}", *at_least(result.share, 0.9, "")],
        [f"{kind.name}: calls until 80 %", f"{reached:g}", *at_most(reached, kind.within, "")],
        [
            f"{kind.name}: in flight over best",
            f"{result.in_flight / result.best[0]:.2f}",
            *at_most(result.in_flight / result.best[0], most, ""),
        ],
        [f"{kind.name}: largest queue", f"{result.queued}", *at_most(result.queued, 512, "")],
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="only kinds of servers whose name contains this text")
    parser.add_argument("--workers", type=int, default=None, help="worker processes (default: as for foundry)")
    chosen = parser.parse_args()
    print_title(
        "Limits",
        f"Sweeps of {AGENTS} agents, {STEPS} steps on simulated servers, each in its own process.",
        "foundry does not know their settings; the baseline is foundry with the best fixed limit, one worker. The best",
        f"limit is the smallest with {100 * AS_GOOD:.0f} % of the largest throughput. The server measures. After a",
        "change of the server, calls until 80 % count from the change, and the baseline uses the best limit for it.",
    )
    rows: list[Sequence[str]] = []
    met: list[Sequence[str]] = []
    for kind in KINDS:
        if chosen.only in kind.name:
            result = measure(kind, chosen.workers)
            rows.append(row(kind, result))
            met += targets(kind, result)
            print(" | ".join(rows[-1]), flush=True)
    columns = ["server", "best limit", "calls/s", "share", "second half", "calls until 80 %", "in flight", "over best"]
    print_table([*columns, "largest queue", "refused"], rows)
    print_table(["", "measured", "target", ""], met)


if __name__ == "__main__":
    main()
