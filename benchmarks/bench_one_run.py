"""How much sooner one run of many agents is over where nobody waits for the slowest reply of all: `runner.ahead`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from measuring import Swept, at_least, print_table, print_title, run_sweep, scratch, serving

SPREAD = 0.7
"""Standard deviation of the logarithm of the replies' lengths."""


@dataclass(frozen=True)
class Kind:
    """A run, and the server that it asks.

    Attributes:
        agents: number of them.
        half_size: of the grid.
        steps: number of them.
        slots: calls that the server works on at once, which is the limit on the calls in flight too.
        mean_s: seconds of work per call, on average.
        least: lock-step time over ahead time that is asked for.
    """

    agents: int
    half_size: int
    steps: int
    slots: int
    mean_s: float
    least: float


KINDS = (
    Kind(100, 100, 6, 16, 0.1, 1.2),
    Kind(100, 100, 10, 64, 0.22, 1.5),
    Kind(100, 100, 10, 256, 0.22, 1.5),
    Kind(20, 25, 10, 16, 0.2, 1.3),
    Kind(20, 25, 10, 64, 0.2, 1.3),
)


def played(kind: Kind, folder: Path, *, ahead: bool) -> Swept:
    """Play the run with an empty cache, against a fresh server."""
    with serving("slots_server.py", f"--slots={kind.slots}", f"--mean={kind.mean_s}", f"--spread={SPREAD}") as to:
        return run_sweep(
            folder / "sweep",
            f"model.server.hosts='{to.url}'",
            f"model.server.in_flight={{min: {kind.slots}, max: {kind.slots}, initial: {kind.slots}}}",
            f"world.agents={kind.agents}",
            f"world.half_size={kind.half_size}",
            f"world.steps={kind.steps}",
            "seed=0",
            "runner.workers=1",
            f"runner.ahead={str(ahead).lower()}",
        )


def records_of(swept: Swept) -> list[bytes]:
    """Return the run's records."""
    (run,) = swept.folder.runs()
    return [run.stream_path(name).read_bytes() for name in ("steps", "messages")]


def measure(kind: Kind) -> tuple[Sequence[str], Sequence[str]]:
    """Play a run both ways; returns what came of it, and beside what is asked for."""
    with scratch(in_memory=True) as first, scratch(in_memory=True) as second:
        lock_step, ahead = played(kind, first, ahead=False), played(kind, second, ahead=True)
        if records_of(lock_step) != records_of(ahead):
            raise RuntimeError("The records differ.")
    walls = [one.running.wall_s for one in (lock_step, ahead)]
    busy = [lock_step.calls * kind.mean_s / wall / min(kind.slots, kind.agents) for wall in walls]
    cpu = [1000 * one.running.cpu_s / one.calls for one in (lock_step, ahead)]
    ratio = walls[0] / walls[1]
    side = 2 * kind.half_size + 1
    name = f"{kind.agents} agents, {side} x {side}, {kind.slots} slots"
    cells = [*(f"{wall:.1f} s" for wall in walls), *(f"{share:.2f}" for share in busy), *(f"{ms:.2f} ms" for ms in cpu)]
    return [name, *cells, f"{ratio:.2f}"], [name, f"{ratio:.2f}", *at_least(ratio, kind.least, "")]


def main() -> None:
    """Measure every kind, or those of so many slots."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--slots", type=int, default=None, help="only servers with so many slots")
    chosen = parser.parse_args().slots
    print_title(
        "One large run",
        f"Replies are log-normal ({SPREAD}), of the same length both ways; the server has a process of its own. Busy:",
        "the share of the slots, or of the agents where these are fewer, at work. The records are equal to the byte.",
    )
    found = [measure(kind) for kind in KINDS if chosen in (None, kind.slots)]
    columns = ("run", "lock-step", "ahead", "busy", "ahead", "CPU a call", "ahead", "lock-step over ahead")
    print_table(columns, [row for row, _ in found])
    print_table(("lock-step over ahead", "measured", "target", ""), [met for _, met in found])


if __name__ == "__main__":
    main()
