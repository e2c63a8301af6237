"""Time per call and per run as agents, steps, runs and workers grow: what is linear keeps it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from measuring import Cost, Swept, at_least, at_most, print_table, print_title, run_sweep, scratch

SCRIPTED = ("model=scripted/random", "runner.workers=1")
CELLS_PER_AGENT = 130
"""As in the shipped world, so that an agent sees equally many others however many there are."""
LONG_ENOUGH_S = 1.0
LINEAR = 1.5
"""What costs this much more per unit at the largest size than at the smallest is no longer called linear."""


@dataclass(frozen=True)
class Axis:
    """One thing that grows.

    Attributes:
        name: what grows.
        unit: what its time is given per.
        sizes: from the smallest to the largest.
        overrides: the command line of a size.
        units: how many units a sweep has done.
    """

    name: str
    unit: str
    sizes: Sequence[int]
    overrides: Callable[[int], Sequence[str]]
    units: Callable[[Swept], int]


def agents(count: int) -> list[str]:
    half_size = max(25, math.ceil((math.sqrt(CELLS_PER_AGENT * count) - 1) / 2))
    return [f"world.agents={count}", "world.steps=1", f"world.half_size={half_size}", "seed=0"]


def steps(count: int) -> list[str]:
    return ["world.agents=20", f"world.steps={count}", "seed=0"]


def runs(count: int) -> list[str]:
    return ["world.agents=2", "world.steps=1", f"seed=0-{count - 1}"]


AXES = (
    Axis("agents, one step", "call", (10, 100, 1_000, 10_000), agents, lambda swept: swept.calls),
    Axis("steps, 20 agents", "call", (10, 50, 250), steps, lambda swept: swept.calls),
    Axis("runs of 2 agents and one step", "run", (10, 100, 1_000), runs, lambda swept: len(swept.folder.runs())),
)


def best(repeats: int, *overrides: str) -> Swept:
    """Run a sweep; again as often as asked while it is short, and return the fastest."""
    done: list[Swept] = []
    while not done or (len(done) < repeats and done[-1].whole.wall_s < LONG_ENOUGH_S):
        with scratch() as folder:
            done.append(run_sweep(Path(folder) / "sweep", *overrides))
    return min(done, key=lambda one: one.whole.cpu_s)


@dataclass(frozen=True)
class Point:
    """What one size of an axis took, all in."""

    size: int
    units: int
    cost: Cost

    @property
    def per_unit_us(self) -> float:
        """CPU of a unit, fixed costs included, microseconds."""
        return 1e6 * self.cost.cpu_s / self.units

    def further_us(self, smaller: Point) -> float:
        """CPU of each unit that a smaller size does not have, so without fixed costs, microseconds."""
        return 1e6 * (self.cost.cpu_s - smaller.cost.cpu_s) / (self.units - smaller.units)


def point(axis: Axis, size: int) -> Point:
    swept = best(3, *SCRIPTED, *axis.overrides(size))
    return Point(size, axis.units(swept), swept.whole)


def rows_of(axis: Axis, points: Sequence[Point]) -> list[list[str]]:
    further = ["", *(f"{after.further_us(before):,.0f}" for before, after in pairwise(points))]
    return [
        [
            axis.name,
            f"{each.size:,}",
            f"{each.units:,} {axis.unit}s",
            f"{each.cost.wall_s:.3f}",
            f"{each.cost.cpu_s:.3f}",
            f"{each.per_unit_us:,.0f}",
            f"{each.per_unit_us / points[0].per_unit_us:.2f}",
            more,
        ]
        for each, more in zip(points, further, strict=True)
    ]


def target_rows(axis: Axis, points: Sequence[Point]) -> list[list[str]]:
    """Return whether the CPU is linear, with the fixed costs and without."""
    whole = points[-1].per_unit_us / points[0].per_unit_us
    slopes = [after.further_us(before) for before, after in pairwise(points)]
    further = slopes[-1] / slopes[-2]
    return [
        [f"{axis.name}: a {axis.unit}, largest to smallest", f"{whole:.2f}", *at_most(whole, LINEAR, "")],
        [f"{axis.name}: each further {axis.unit}, last to before", f"{further:.2f}", *at_most(further, LINEAR, "")],
    ]


def print_workers() -> None:
    """Run the same sweep with one worker and with two."""
    overrides = ("model=scripted/random", "world.agents=20", "world.steps=50", "seed=0-59")
    one, two = (best(1, *overrides, f"runner.workers={workers}") for workers in (1, 2))
    rows = [
        [f"{workers}", f"{swept.running.wall_s:.2f}", f"{swept.calls:,}", f"{swept.per_s_once_begun(workers):,.0f}"]
        for workers, swept in ((1, one), (2, two))
    ]
    print_table(["workers", "all s, their start included", "calls", "calls/s once a first run has ended"], rows)
    if (os.cpu_count() or 1) > 1:
        gain = two.per_s_once_begun(2) / one.per_s_once_begun(1)
        target = at_least(gain, 1.5, "")
        print_table(
            ["growth", "ratio", "target", ""], [["calls/s of 2 workers to 1, once begun", f"{gain:.2f}", *target]]
        )


def main() -> None:
    print_title(
        "Growth",
        "Scripted model, one worker, all in from composing to the last record, inside the process. Best of three where",
        f"one takes less than {LONG_ENOUGH_S:g} s. The field grows with the agents, at equal density. Ratios are to",
        "the smallest size. 'Each further' is what a unit costs that the size above does not have, so without fixed costs.",
    )
    best(1, *SCRIPTED, *steps(1))  # what is imported on first use is start-up
    rows: list[list[str]] = []
    targets: list[list[str]] = []
    for axis in AXES:
        points = [point(axis, size) for size in axis.sizes]
        rows += rows_of(axis, points)
        targets += target_rows(axis, points)
    columns = ["what grows", "size", "units", "wall s", "CPU s", "CPU µs per unit", "ratio", "CPU µs each further"]
    print_table(columns, rows)
    print_table(["growth", "ratio", "target", ""], targets)
    print_workers()


if __name__ == "__main__":
    main()
