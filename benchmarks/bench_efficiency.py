"""How busy a sweep keeps a server with k slots, beside a bare client: sum of service times over wall time times k."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from bench_live_calls import aiohttp_sample, bodies_of, logged_calls
from measuring import Server, Swept, at_least, print_table, print_title, run_together, scratch, serving

SLOTS = (4, 8)
MEAN_S = 0.12
STEPS = (1, 2, 3, 4)
SEEDS = 50
WAITING = 4
"""Calls of the bare client that wait in the server's queue."""
BARE_S = 6.0
TARGET = 0.95


@dataclass(frozen=True)
class Busy:
    """How busy a server was.

    Attributes:
        calls: calls that it answered.
        service_s: sum of their service times.
        wall_s: seconds from the start of the sweep to its end.
        calls_s: seconds from the first call to the end of the last run.
    """

    calls: int
    service_s: float
    wall_s: float
    calls_s: float

    def efficiency(self, slots: int) -> float:
        """Return the share of the slots' time that was used, start-up included."""
        return self.service_s / (self.wall_s * slots)

    def once_begun(self, slots: int) -> float:
        """Return the same from the first call on."""
        return self.service_s / (self.calls_s * slots)


def busy(swept: Swept, begun: float) -> Busy:
    """Return how busy the server of a sweep was whose first call came at the time `begun`."""
    ended = max(datetime.fromisoformat(one.ended) for one in swept.summaries).timestamp()
    if swept.cached:
        raise RuntimeError(f"{swept.cached} answers came from the cache, which takes none of the server's time.")
    return Busy(swept.calls, sum(service_times(swept)), swept.running.wall_s, ended - begun)


def service_times(swept: Swept) -> list[float]:
    """Return the seconds that the server worked on each call, as it says itself."""
    return [call.timings["prompt"] + call.timings["output"] for call in logged_calls(swept.folder)]


def sweep(folder: Path, to: Server) -> Swept:
    """Run two hundred runs of four lengths, the shortest first in their order."""
    common = (f"model.server.hosts='{to.url}'", "world.agents=2", "runner.workers=2")
    # Seeds of their own: runs of one seed that differ in their length alone would share their answers.
    parts = [
        (*common, f"world.steps={steps}", f"seed={SEEDS * number}-{SEEDS * (number + 1) - 1}")
        for number, steps in enumerate(STEPS)
    ]
    return run_together(folder / "sweep", *parts)


def bare(to: Server, slots: int, swept: Swept) -> Busy:
    """Post what the sweep posted first, with always a few calls waiting; nothing else is done."""
    count = int(BARE_S * slots / MEAN_S)
    sample = asyncio.run(aiohttp_sample(to, bodies_of(swept)[:count], slots + WAITING))
    wall_s = sample.cost.wall_s
    return Busy(sample.calls, sum(service_times(swept)[:count]), wall_s, wall_s)


def row(slots: int, client: str, found: Busy, baseline: Busy) -> list[str]:
    value = found.once_begun(slots)
    return [
        f"{slots}",
        client,
        f"{found.calls:,}",
        f"{found.service_s / slots:.1f}",
        f"{found.wall_s:.1f}",
        f"{found.efficiency(slots):.3f}",
        f"{value:.3f}",
        f"{value / baseline.once_begun(slots):.3f}",
    ]


def main() -> None:
    print_title(
        "Efficiency",
        f"{len(STEPS) * SEEDS} runs of 2 agents and {', '.join(map(str, STEPS))} steps on 2 workers; service times",
        f"log-normal, mean {1000 * MEAN_S:.0f} ms. Efficiency: sum of service times / (wall time x slots). The limit",
        "on the calls in flight starts at 1 and finds the slots itself. Ratios are to a bare aiohttp client that knows",
        f"the slots, keeps {WAITING} calls waiting and has no tail; what it loses, server and machine lose. Until the",
        "first call the workers start, a second or two that long sweeps do not notice.",
    )
    rows: list[Sequence[str]] = []
    targets: list[Sequence[str]] = []
    for slots in SLOTS:
        with scratch() as folder:
            begun = folder / "begun"
            with serving("slots_server.py", f"--slots={slots}", f"--mean={MEAN_S}", f"--begun={begun}") as to:
                swept = sweep(folder, to)
                ours = busy(swept, float(begun.read_text(encoding="utf-8")))
                theirs = bare(to, slots, swept)
        rows += [row(slots, "foundry, all in", ours, theirs), row(slots, "bare aiohttp", theirs, theirs)]
        for name, value in (("all in", ours.efficiency(slots)), ("from the first call on", ours.once_begun(slots))):
            targets.append([f"{slots} slots, {name}", f"{value:.3f}", *at_least(value, TARGET, "")])
    columns = [
        "slots",
        "client",
        "calls",
        "service s / slots",
        "wall s",
        "efficiency",
        "from the first call on",
        "ratio",
    ]
    print_table(columns, rows)
    print_table(["efficiency", "measured", "target", ""], targets)


if __name__ == "__main__":
    main()
