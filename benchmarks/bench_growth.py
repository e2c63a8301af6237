"""Time per call and per run as agents, steps, runs and workers grow: what is linear keeps it."""

from __future__ import annotations

import math
import resource
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from measuring import Cost, Swept, at_least, at_most, most_runs, print_table, print_title, run_sweep, scratch

SCRIPTED = ("model=scripted/random", "runner.workers=1")
CELLS_PER_AGENT = 130
"""As in the shipped world, so that an agent sees equally many others however many there are."""
REPEATS, BUDGET_S = 5, 5.0
LINEAR = 2.0
"""What costs more than this times as much per unit is not called linear; a quadratic cost would show five to ten."""


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


RUNS = (10, 100, 1_000, 10_000)
AXES = (
    Axis("agents, one step", "call", (10, 100, 1_000, 10_000), agents, lambda swept: swept.calls),
    Axis("steps, 20 agents", "call", (10, 50, 250), steps, lambda swept: swept.calls),
    Axis("runs of 2 agents and one step", "run", RUNS, runs, lambda swept: len(swept.folder.runs())),
)


def repeated(*overrides: str) -> list[Swept]:
    """Run a sweep in fresh folders several times, fewer where the budget of seconds is used up before."""
    done: list[Swept] = []
    while len(done) < REPEATS and sum(one.whole.wall_s for one in done) < BUDGET_S:
        with scratch(in_memory=True) as folder:
            done.append(run_sweep(folder / "sweep", *overrides))
    return done


@dataclass(frozen=True)
class Point:
    """What one size of an axis took, all in."""

    size: int
    units: int
    cost: Cost

    @property
    def per_unit_us(self) -> float:
        """User CPU of a unit, fixed costs included, microseconds."""
        return 1e6 * self.cost.user_s / self.units

    def further_us(self, smaller: Point) -> float:
        """User CPU of each unit that a smaller size does not have, so without fixed costs, microseconds."""
        return 1e6 * (self.cost.user_s - smaller.cost.user_s) / (self.units - smaller.units)


def point(axis: Axis, size: int) -> Point:
    swept = min(repeated(*SCRIPTED, *axis.overrides(size)), key=lambda one: one.whole.user_s)
    return Point(size, axis.units(swept), swept.whole)


def rows_of(axis: Axis, points: Sequence[Point]) -> list[list[str]]:
    further = ["", *(f"{after.further_us(before):,.0f}" for before, after in pairwise(points))]
    return [
        [
            axis.name,
            f"{each.size:,}",
            f"{each.units:,} {axis.unit}s",
            f"{each.cost.wall_s:.3f}",
            f"{each.cost.user_s:.2f}",
            f"{each.cost.cpu_s - each.cost.user_s:.2f}",
            f"{each.per_unit_us:,.0f}",
            f"{each.per_unit_us / points[0].per_unit_us:.2f}",
            more,
        ]
        for each, more in zip(points, further, strict=True)
    ]


def target_rows(axis: Axis, points: Sequence[Point]) -> list[list[str]]:
    """Return whether the user CPU is linear, with the fixed costs and without."""
    whole = points[-1].per_unit_us / points[0].per_unit_us
    slopes = [after.further_us(before) for before, after in pairwise(points)]
    further = slopes[-1] / slopes[-2]
    return [
        [f"{axis.name}: a {axis.unit}, largest to smallest", f"{whole:.2f}", *at_most(whole, LINEAR, "")],
        [f"{axis.name}: each further {axis.unit}, last to before", f"{further:.2f}", *at_most(further, LINEAR, "")],
    ]


def print_memory() -> None:
    """Play a few runs, then many, in this process; print its most memory after each."""
    rows = []
    for count in (100, 1_000):
        with scratch(in_memory=True) as folder:
            run_sweep(folder / "sweep", *SCRIPTED, *runs(count))
        rows.append([f"{count:,}", f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:,.0f}"])
    print_table(["runs of 2 agents and one step", "most memory of the worker so far, MB"], rows)


def print_workers() -> None:
    """Run the same sweep with one worker and with two."""
    overrides = ("model=scripted/random", "world.agents=20", "world.steps=50", "seed=0-29")
    best = {
        workers: max(repeated(*overrides, f"runner.workers={workers}"), key=lambda one: one.per_s_once_begun(workers))
        for workers in (1, 2)
    }
    per_s = {workers: swept.per_s_once_begun(workers) for workers, swept in best.items()}
    rows = [
        [f"{workers}", f"{swept.calls:,}", f"{swept.running.wall_s:.2f}", f"{per_s[workers]:,.0f}"]
        for workers, swept in best.items()
    ]
    print_table(["workers", "calls", "wall s, start included", "calls/s once a first run has ended"], rows)
    gain = per_s[2] / per_s[1]
    row = ["calls/s of 2 workers to those of 1, once begun", f"{gain:.2f}", *at_least(gain, 1.5, "")]
    print_table(["growth", "ratio", "target", ""], [row])


def main() -> None:
    most = most_runs(__doc__)
    print_title(
        "Growth",
        "Scripted model, one worker, all in from composing to the last record, inside the process. Least user CPU of",
        f"{REPEATS}, or of fewer where they take over {BUDGET_S:g} s. The kernel's part is the making of files, here",
        "in memory where the system has a place for them, since a disk's speed is its own. The field grows with the",
        "agents, at equal density. Ratios are to the smallest size. 'Each further' is what a unit costs that the size",
        "above does not have, so without fixed costs.",
    )
    repeated(*SCRIPTED, *steps(1))  # what is imported on first use is start-up
    print_memory()
    rows: list[list[str]] = []
    targets: list[list[str]] = []
    for axis in AXES:
        points = [point(axis, size) for size in axis.sizes if axis.sizes is not RUNS or size <= most]
        rows += rows_of(axis, points)
        targets += target_rows(axis, points)
    columns = [
        "what grows",
        "size",
        "units",
        "wall s",
        "user s",
        "kernel s",
        "user µs per unit",
        "ratio",
        "user µs each further",
    ]
    print_table(columns, rows)
    print_table(["growth", "ratio", "target", ""], targets)
    print_workers()


if __name__ == "__main__":
    main()
