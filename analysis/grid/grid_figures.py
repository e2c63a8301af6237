"""Computes the content of plots of 2D worlds: positions of agents, times to warnings, chains of warnings."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from analysis.arrays import BoolArray, FloatArray, IntArray
from analysis.figures.shown import ShownGroup
from analysis.formulas import survival
from analysis.grid.cascade import NEVER, NOBODY, first_step, trace
from analysis.grid.grid_run import NO_EXIT, OUTSIDE, GridRun, GridSettings
from analysis.grid.plots.grid_plots import CascadeEdge, CascadeTree, SurvivalCurve
from analysis.grid.plots.occupancy import OccupancyMap
from analysis.grid.signatures.warning import deliveries_of, find_labels, waiting_times
from analysis.plots.rounds import Curve
from analysis.stats.intervals import estimates

COURSES: Mapping[str, Callable[[GridRun], BoolArray]] = {
    "moved (share)": lambda run: run.moved,
    "spoke (share)": lambda run: run.spoke,
    "in a place (share)": lambda run: run.place[1:] != OUTSIDE,
}
"""Curves over the steps. For each title, a function returns whether each agent moved, spoke and so on, (T, N)."""
MOST_SEEDS = 12
"""Maximum number of seeds for which the positions of groups are compared step by step."""


@dataclass(frozen=True)
class Ways:
    """Paths of the agents of a run: columns and rows by state and agent, (T + 1, N) each."""

    shown: ShownGroup
    x: IntArray
    y: IntArray


@dataclass
class GridGroup:
    """Collects the plot data of the runs of one group; it keeps a single run, as an example.

    Attributes:
        counts: share of agent-steps in each cell, summed over runs, (W, W).
        curves: share of agents not yet warned after each step, by run.
        present: share of the initial agents still present after each step, by run; empty if no agent ever leaves.
        courses: share of agents for each of `COURSES` in each step, by run.
        places: positions of agents by seed, x and y, (2, T + 1, N), for the first `MOST_SEEDS` seeds.
    """

    shown: ShownGroup
    seed: int
    world: GridSettings
    counts: FloatArray = field(init=False)
    curves: list[FloatArray] = field(default_factory=list)
    present: list[FloatArray] = field(default_factory=list)
    courses: list[Mapping[str, FloatArray]] = field(default_factory=list)
    places: dict[int, IntArray] = field(default_factory=dict)
    example: GridRun | None = None
    runs: int = 0

    def __post_init__(self) -> None:
        self.counts = np.zeros((self.world.width, self.world.width))

    def add(self, run: GridRun, seed: int) -> None:
        """Add a run."""
        self.counts += occupancy(run)
        if run.perceived.any():
            self.curves.append(not_warned(run))
        if run.present is not None:
            self.present.append(still_there(run))
        there = np.maximum(run.there.sum(axis=1), 1)
        self.courses.append({name: (is_so(run) & run.there).sum(axis=1) / there for name, is_so in COURSES.items()})
        if len(self.places) < MOST_SEEDS and run.present is None:
            self.places.setdefault(seed, np.array([run.x, run.y], dtype=np.int16))
        if seed == self.seed and self.example is None:
            self.example = run
        self.runs += 1

    def occupancy_map(self) -> OccupancyMap:
        """Return the map of the agents' positions, as mean over runs."""
        return OccupancyMap(self.shown, self.world, self.counts / self.runs)

    def survival_curve(self) -> SurvivalCurve | None:
        """Return the share of agents not yet warned, with an interval over runs; None if no agent perceives a fire."""
        return self._mean_curve(self.curves)

    def presence_curve(self) -> SurvivalCurve | None:
        """Return the share of agents still present, with an interval over runs; None if no agent ever leaves."""
        return self._mean_curve(self.present)

    def course(self, name: str) -> Curve:
        """Return the curve of one of `COURSES`: a share of agents at each step, with an interval over runs."""
        return curve_of(self.shown, [course[name] for course in self.courses], 1.0)

    def _mean_curve(self, curves: Sequence[FloatArray]) -> SurvivalCurve | None:
        if not curves:
            return None
        curve = curve_of(self.shown, curves, 1.0)
        return SurvivalCurve(self.shown, curve.mean, curve.low, curve.high, curve.runs)


def curve_of(shown: ShownGroup, curves: Sequence[FloatArray], most: float) -> Curve:
    """Return the mean of curves with an interval over curves, up to the end of the shortest curve.

    Args:
        shown: the group.
        curves: values by step, between 0 and `most`.
        most: largest possible value.
    """
    steps = min(len(curve) for curve in curves)
    values = np.array([curve[:steps] for curve in curves]).T
    curve = estimates(values, np.zeros(steps), np.full(steps, most))
    return Curve(shown.label, curve.mean, curve.low, curve.high, len(curves), shown.index, shown.baseline)


def divergence(groups: Sequence[GridGroup]) -> list[Curve]:
    """Return how far the agents of each group are from the same agents in other groups, in runs with the same seed.

    Each curve is a mean distance by step, in cells. A group is compared only with groups that have the same number of
    agents and share a seed with it.
    """
    curves = []
    for group in groups:
        by_seed = [
            curve
            for seed, mine in group.places.items()
            if (curve := _distance(mine, [group.places[seed] for group in groups if seed in group.places])) is not None
        ]
        if by_seed:
            distance_curve = curve_of(group.shown, by_seed, np.inf)
            curves.append(replace(distance_curve, at=np.arange(len(distance_curve.mean), dtype=np.float64)))
    return curves


def _distance(mine: IntArray, every: Sequence[IntArray]) -> FloatArray | None:
    others = [places for places in every if places is not mine and places.shape[2] == mine.shape[2]]
    if not others:
        return None
    steps = min(places.shape[1] for places in (mine, *others))
    apart = [np.hypot(*(mine[:, :steps].astype(np.float64) - other[:, :steps])).mean(axis=1) for other in others]
    by_step: FloatArray = np.mean(apart, axis=0)
    return by_step


def occupancy(run: GridRun) -> FloatArray:
    """Return the share of agent-steps by row and column of the grid, (W, W), without the start positions."""
    half, width = run.world.half_size, run.world.width
    counts = np.zeros((width, width), dtype=np.float64)
    np.add.at(counts, (run.y[1:][run.there] + half, run.x[1:][run.there] + half), 1.0)
    share: FloatArray = counts / counts.sum()
    return share


def still_there(run: GridRun) -> FloatArray:
    """Return the share of the initial agents that have neither left nor died, after each of the steps 0..T, (T + 1,).

    T is the planned number of steps. If a run ends early because no agent is left, the share stays 0.
    """
    start = run.there[:, : run.world.agents]
    stays = start[-1].copy()
    for gone in (None if run.left is None else run.left != NO_EXIT, run.lost):
        if gone is not None:
            stays &= ~gone[-1, : run.world.agents]
    left = np.full(max(0, run.world.steps - run.steps), stays.sum())
    return np.concatenate([start.sum(axis=1), [stays.sum()], left]) / run.world.agents


def not_warned(run: GridRun) -> FloatArray:
    """Return the Kaplan-Meier estimate of the share of agents not yet warned after steps 0..T, (T + 1,).

    An agent that perceives a fire before any warning is censored one step earlier.
    """
    events, remaining = survival(*waiting_times(run, find_labels(run)[0]))
    after = np.searchsorted(events, np.arange(run.steps + 1), side="right")
    curve: FloatArray = np.concatenate(([1.0], remaining))[after]
    return curve


def cascade_tree(run: GridRun, shown: ShownGroup) -> CascadeTree:
    """Return the chains of first warnings in a run."""
    warned, _ = find_labels(run)
    perceived_at, warned_at = first_step(run.perceived), first_step(warned)
    cascade = trace(perceived_at, warned_at, deliveries_of(run, warned))
    learnt = np.minimum(cascade.told_at, perceived_at)
    linked = [int(agent) for agent in np.flatnonzero(cascade.parent != NOBODY)]
    senders = np.isin(np.arange(run.agents), cascade.parent[linked])
    unfounded = senders & (warned_at < learnt)
    since = np.where(unfounded, warned_at, learnt)
    known = [int(agent) for agent in np.flatnonzero(since < NEVER)]
    return CascadeTree(
        shown=shown,
        run=run.id,
        steps=run.steps,
        rows=tuple(_in_order(known, since, cascade.parent)),
        since={agent: int(since[agent]) for agent in known},
        direct=frozenset(agent for agent in known if cascade.direct[agent]),
        unfounded=frozenset(np.flatnonzero(unfounded).tolist()),
        informed=int((learnt < NEVER).sum()),
        edges=tuple(CascadeEdge(int(cascade.told_at[agent]), int(cascade.parent[agent]), agent) for agent in linked),
        agents=run.agents,
    )


def _in_order(known: Sequence[int], since: IntArray, parent: IntArray) -> list[int]:
    """Sort agents so that each comes after the agent that warned it.

    Agents that the same agent warned are sorted by the step at which they were told.
    """
    below: dict[int, list[int]] = {}
    for agent in sorted(known, key=lambda agent: (int(since[agent]), agent)):
        below.setdefault(int(parent[agent]), []).append(agent)
    ordered: list[int] = []
    waiting = list(reversed(below.get(NOBODY, [])))
    while waiting:
        agent = waiting.pop()
        ordered.append(agent)
        waiting += reversed(below.get(agent, []))
    return ordered
