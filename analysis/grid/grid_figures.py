"""What plots of 2D worlds show: where agents were, how long until they were warned, who warned whom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from analysis.arrays import FloatArray, IntArray
from analysis.figures.shown import Shown
from analysis.grid.cascade import NEVER, NOBODY, first_step, trace
from analysis.grid.grid_run import NO_EXIT, GridRun, GridSettings
from analysis.grid.plots.grid_plots import CascadeEdge, CascadeTree, SurvivalCurve
from analysis.grid.plots.occupancy import OccupancyMap
from analysis.grid.signatures.warning import deliveries_of, find_labels, waiting_times
from analysis.kaplan_meier import survival
from analysis.stats.intervals import estimates


@dataclass
class GridGroup:
    """Gathers what is shown of the runs of one group, so that none of them has to be kept.

    Attributes:
        shown: the group.
        seed: the seed whose run is shown.
        world: the settings of their world.
        counts: agent-steps by run and cell, as shares, summed over runs.
        curves: how many agents are not warned yet, by run.
        present: how many agents of the start are still there, by run; none where all always are.
        example: the run of the seed that is shown.
        runs: how many runs were added.
    """

    shown: Shown
    seed: int
    world: GridSettings
    counts: FloatArray = field(init=False)
    curves: list[FloatArray] = field(default_factory=list)
    present: list[FloatArray] = field(default_factory=list)
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
        if seed == self.seed and self.example is None:
            self.example = run
        self.runs += 1

    def occupancy_map(self) -> OccupancyMap:
        """Return where the agents were, the mean over runs."""
        return OccupancyMap(self.shown, self.world, self.counts / self.runs)

    def survival_curve(self) -> SurvivalCurve | None:
        """Return how many agents are not warned yet, with an interval over runs; None when no run has a fire seen."""
        return self._mean_curve(self.curves)

    def presence_curve(self) -> SurvivalCurve | None:
        """Return how many agents are still there, with an interval over runs; None when all always are."""
        return self._mean_curve(self.present)

    def _mean_curve(self, curves: Sequence[FloatArray]) -> SurvivalCurve | None:
        if not curves:
            return None
        steps = min(len(curve) for curve in curves)
        values = np.array([curve[:steps] for curve in curves]).T
        found = estimates(values, np.zeros(steps), np.ones(steps))
        return SurvivalCurve(self.shown, found.mean, found.low, found.high, len(curves))


def occupancy(run: GridRun) -> FloatArray:
    """Return the share of agent-steps by row and column of the grid, without the start, (W, W)."""
    half, width = run.world.half_size, run.world.width
    counts = np.zeros((width, width), dtype=np.float64)
    np.add.at(counts, (run.y[1:][run.there] + half, run.x[1:][run.there] + half), 1.0)
    share: FloatArray = counts / counts.sum()
    return share


def still_there(run: GridRun) -> FloatArray:
    """Return the share of the agents of the start that have neither left nor died after steps 0..T, (T + 1,).

    T is the number of steps that were planned. A run that ends before since nobody is left has 0 from then on.
    """
    start = run.there[:, : run.world.agents]
    stays = start[-1].copy()
    for gone in (None if run.left is None else run.left != NO_EXIT, run.lost):
        if gone is not None:
            stays &= ~gone[-1, : run.world.agents]
    left = np.full(max(0, run.world.steps - run.steps), stays.sum())
    return np.concatenate([start.sum(axis=1), [stays.sum()], left]) / run.world.agents


def not_warned(run: GridRun) -> FloatArray:
    """Return the Kaplan-Meier estimate of the share that is not warned yet at steps 0..T, (T + 1,).

    An agent that perceives a fire itself, untold, is censored the step before.
    """
    events, remaining = survival(*waiting_times(run, find_labels(run)[0]))
    after = np.searchsorted(events, np.arange(run.steps + 1), side="right")
    curve: FloatArray = np.concatenate(([1.0], remaining))[after]
    return curve


def cascade_tree(run: GridRun, shown: Shown) -> CascadeTree:
    """Return who warned whom in a run."""
    warned, _ = find_labels(run)
    perceived_at, warned_at = first_step(run.perceived), first_step(warned)
    found = trace(perceived_at, warned_at, deliveries_of(run, warned))
    learnt = np.minimum(found.told_at, perceived_at)
    linked = [int(agent) for agent in np.flatnonzero(found.parent != NOBODY)]
    senders = np.isin(np.arange(run.agents), found.parent[linked])
    unfounded = senders & (warned_at < learnt)
    since = np.where(unfounded, warned_at, learnt)
    known = [int(agent) for agent in np.flatnonzero(since < NEVER)]
    return CascadeTree(
        shown=shown,
        run=run.id,
        steps=run.steps,
        rows=tuple(_in_order(known, since, found.parent)),
        since={agent: int(since[agent]) for agent in known},
        direct=frozenset(agent for agent in known if found.direct[agent]),
        unfounded=frozenset(np.flatnonzero(unfounded).tolist()),
        informed=int((learnt < NEVER).sum()),
        edges=tuple(CascadeEdge(int(found.told_at[agent]), int(found.parent[agent]), agent) for agent in linked),
        agents=run.agents,
    )


def _in_order(known: Sequence[int], since: IntArray, parent: IntArray) -> list[int]:
    """Return the agents so that each stands below the one that told it, earlier ones first."""
    below: dict[int, list[int]] = {}
    for agent in sorted(known, key=lambda one: (int(since[one]), one)):
        below.setdefault(int(parent[agent]), []).append(agent)
    ordered: list[int] = []
    waiting = list(reversed(below.get(NOBODY, [])))
    while waiting:
        agent = waiting.pop()
        ordered.append(agent)
        waiting += reversed(below.get(agent, []))
    return ordered
