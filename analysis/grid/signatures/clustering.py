"""Clustering: how close together agents are, and which agents can hear each other.

State 0, the start, never counts, because the seed draws the start.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from analysis.arrays import BoolArray, FloatArray, IntArray
from analysis.formulas import ratio, weighted_mean
from analysis.grid.grid_run import GridRun
from analysis.measure import Measure, Null, share
from foundry import seeding

DRAWS = 999
"""Number of times that agents are placed at random to compute the null of a measure."""

_PAIRS = 2**20
"""Maximum number of pairs of agents that are in memory at once."""

_SEED = 1954
"""Seed of every null, so that every machine gets the same results."""


@dataclass(frozen=True)
class Closeness:
    """Measures of how close the agents are in each state, (S,) each.

    Attributes:
        nearest: mean over agents of the Euclidean distance to the nearest other agent, cells.
        pairs: share of the pairs of agents that are within the radius. Multiplied by the area of the grid, it is
            Ripley's K without edge correction.
        ripley: Ripley's K at the radius with translation edge correction, cells squared.
    """

    nearest: FloatArray
    pairs: FloatArray
    ripley: FloatArray


@dataclass(frozen=True)
class Placements:
    """Mean distances between agents that are placed at random, over DRAWS placements.

    Attributes:
        nearest: mean distance to the nearest other agent, over agents and placements, cells.
        deviation: standard deviation over placements of this mean over agents, ddof 0.
        besag: mean over placements of Besag's L(r) - r, cells.
    """

    nearest: float
    deviation: float
    besag: float


def closeness(x: IntArray, y: IntArray, side: int, radius: float) -> Closeness:
    """Return how close the agents are in each state.

    Args:
        x: columns by state and agent, (S, N), N >= 2.
        y: rows, same shape.
        side: number of cells along each axis of the grid.
        radius: radius at which Ripley's K is computed, cells.
    """
    size = max(1, _PAIRS // x.shape[1] ** 2)
    starts = range(0, len(x), size)
    parts = [_closeness(x[start : start + size], y[start : start + size], side, radius) for start in starts]
    return Closeness(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _closeness(x: IntArray, y: IntArray, side: int, radius: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    x, y = x.astype(np.int32), y.astype(np.int32)
    wide, high = np.abs(x[:, :, None] - x[:, None]), np.abs(y[:, :, None] - y[:, None])
    squared = wide**2 + high**2
    agents = np.arange(x.shape[1])
    squared[:, agents, agents] = np.iinfo(np.int32).max
    nearest = np.sqrt(squared.min(axis=2)).mean(axis=1)
    near = np.flatnonzero(squared <= radius**2)
    # Translation correction: a pair counts more if it can be shifted as a whole to fewer positions on the grid.
    margin_product = (side - wide.ravel()[near]) * (side - high.ravel()[near])
    pairs, state = len(agents) * (len(agents) - 1), near // len(agents) ** 2
    weights = np.bincount(state, weights=side**2 / margin_product, minlength=len(x))
    return nearest, np.bincount(state, minlength=len(x)) / pairs, weights * side**2 / pairs


def besag(ripley: FloatArray, radius: float) -> FloatArray:
    """Return Besag's L(r) - r, computed from Ripley's K at r, cells; 0 for random points, above 0 if clustered."""
    return np.asarray(np.sqrt(ripley / math.pi) - radius)


@lru_cache(maxsize=64)
def random_placements(agents: int, side: int, radius: float) -> Placements:
    """Return how close to each other agents are in random cells; several agents may share a cell."""
    rng = seeding.stream(_SEED, "random placements")
    x, y = rng.integers(side, size=(2, DRAWS, agents))
    closest = closeness(x, y, side, radius)
    return Placements(
        nearest=float(closest.nearest.mean()),
        deviation=float(closest.nearest.std()),
        besag=float(besag(closest.ripley, radius).mean()),
    )


NAME = "clustering"

_ANYWHERE = "is in any cell with equal chance, without regard to others"

MEASURES = {
    "largest_group": share("Largest group (share of agents)", says="gathers in {larger|smaller} groups"),
    "groups": Measure("Groups of two or more", low=0),
    "isolated": share("Agents with nobody in reach (share)", says="leaves {more|fewer} agents alone"),
    "nni": Measure("Nearest-neighbour index (1: as random placements)", low=0, null=Null(1, _ANYWHERE)),
    "nni_z": Measure("Nearest-neighbour distance (standard deviations from random)", null=Null(0, _ANYWHERE)),
    "nni_donnelly": Measure("Nearest-neighbour index, Donnelly's edge correction", low=0),
    "nni_naive": Measure("Nearest-neighbour index without edge correction", low=0),
    "pairs_in_reach": share("Pairs within the communication distance (share)"),
    "ripley": Measure("Ripley's K at the communication distance (cells squared)", low=0),
    "besag": Measure("Besag's L(r) - r at the communication distance (cells)"),
    "besag_excess": Measure("Besag's L(r) minus its mean over random placements (cells)", null=Null(0, _ANYWHERE)),
}

HEADLINE = ("largest_group", "isolated", "nni")

_DONNELLY = (0.0514, 0.0412)


def measure(run: GridRun) -> dict[str, float]:
    """Return the clustering of a run; all measures are NaN with fewer than two agents.

    In worlds with walls, or with agents that come and go, only largest_group, groups and isolated are measured, among
    the present agents.

    Means over states are weighted by the number of counted decisions that led to each state. Distances are Euclidean,
    as in the world.

    - largest_group: agents in the largest connected component of the graph of recorded neighbours (agents that can hear
      each other) / N. Mean over states 1..T-1, for which neighbours are recorded; 1/N..1. NaN with one step.
    - groups: number of components with two agents or more, averaged in the same way; 0..N/2.
    - isolated: agents without neighbours / agents, pooled over the same states and over agents whose own counted
      decision led there; 0..1.
    - nni: d_obs / mean of d_sim. d is the distance to the nearest other agent, as mean over agents. d_sim is d in 999
      random placements: each cell is equally likely, and several agents may share a cell. Runs with the same N and the
      same grid use the same placements. Mean over states 1..T; from 0 (all in one cell). Below 1 the agents are
      clustered, at 1 random, above 1 regularly spaced. Source: Clark and Evans 1954, with a Monte Carlo expectation,
      since no formula holds for points on a grid.
    - nni_z: (d_obs - mean of d_sim) / standard deviation of d_sim (ddof 0), averaged in the same way; a negative value
      means clustered.
    - nni_donnelly: d_obs over its expectation for points in a continuous rectangle of area W*H with Donnelly's edge
      correction, averaged in the same way. Source: Donnelly 1978.
    - nni_naive: nni_donnelly without the correction; about 1.1 to 1.25 for random positions on small grids.
    - pairs_in_reach: pairs of agents within the communication distance r of each other / pairs, averaged in the same
      way; 0..1. Agents in different places count as a pair, too. pairs_in_reach times the area A of the grid is
      Ripley's K(r) without edge correction.
    - ripley: K(r) = A / (N (N - 1)) * sum over ordered pairs within r of A / ((W - |dx|)(H - |dy|)), cells squared,
      averaged in the same way; from 0. ripley has the translation edge correction. Source: Ripley 1977, Ohser 1983.
    - besag: sqrt(K / pi) - r, cells, averaged in the same way; from -r. Above 0 the agents are clustered at the scale
      r. Source: Besag 1977.
    - besag_excess: besag minus its mean over the random placements, cells. This removes the effect of the grid: a disc
      of cells is not round.

    Denominators: n_states (states that a counted decision led to), n_group_states (states in which groups are
    measured), n_isolation (pairs of an agent and a state).
    """
    nothing = dict.fromkeys(MEASURES, math.nan) | {"n_states": 0.0, "n_group_states": 0.0, "n_isolation": 0.0}
    if run.agents < 2:
        return nothing
    if run.world.walls or not run.there.all():
        return nothing | _groups(run)  # the null has agents anywhere on an open grid, always the same number
    return {**_groups(run), **_indices(run)}


def _groups(run: GridRun) -> dict[str, float]:
    # Neighbours are recorded before a move: neighbours of step t + 1 belong to state t, the result of step t.
    led = run.counted[:-1] & run.there[1:]
    weights, alone = led.sum(axis=1), run.neighbours[1:] == 0
    groups = group_shape(run.contacts, run.there)[1:]
    return {
        "largest_group": weighted_mean(groups[:, 0], weights),
        "groups": weighted_mean(groups[:, 1], weights),
        "isolated": ratio(int((alone & led).sum()), int(led.sum())),
        "n_group_states": float((weights > 0).sum()),
        "n_isolation": float(led.sum()),
    }


def _indices(run: GridRun) -> dict[str, float]:
    side, radius = run.world.width, run.world.communication_distance
    weights = run.counted.sum(axis=1)
    null = random_placements(run.agents, side, radius)
    closest = closeness(run.x[1:], run.y[1:], side, radius)
    observed = weighted_mean(closest.nearest, weights)
    excess = weighted_mean(besag(closest.ripley, radius), weights)
    return {
        "nni": ratio(observed, null.nearest),
        "nni_z": ratio(observed - null.nearest, null.deviation),
        "nni_donnelly": observed / expected_distance(run.agents, side, side),
        "nni_naive": observed / expected_distance(run.agents, side, side, corrected=False),
        "pairs_in_reach": weighted_mean(closest.pairs, weights),
        "ripley": weighted_mean(closest.ripley, weights),
        "besag": excess,
        "besag_excess": excess - null.besag,
        "n_states": float((weights > 0).sum()),
    }


def expected_distance(agents: int, width: float, height: float, *, corrected: bool = True) -> float:
    """Return the expected mean distance to the nearest neighbour for random points in a rectangle.

    If `corrected`, it has Donnelly's edge correction (Donnelly 1978).
    """
    naive = 0.5 * math.sqrt(width * height / agents)
    if not corrected:
        return naive
    constant, per_root = _DONNELLY
    return naive + (constant + per_root / math.sqrt(agents)) * 2 * (width + height) / agents


def _components(nodes: int, first: IntArray, other: IntArray) -> IntArray:
    """Return for each node the lowest node of its connected component, (nodes,); edge k joins one[k] and other[k]."""
    labels = np.arange(nodes)
    while True:
        before = labels.copy()
        least = np.minimum(before[first], before[other])
        for ends in (first, other):
            np.minimum.at(labels, before[ends], least)
        labels = labels[labels]
        if np.array_equal(labels, before):
            return labels


def group_shape(contacts: IntArray, there: BoolArray) -> FloatArray:
    """Return the size of the largest group, as a share of the present agents, and the number of groups, (T, 2).

    A group is a connected component before the move of a step; for the number, groups of two agents or more count.

    Args:
        contacts: rows (1-based step, agent, neighbour), (K, 3).
        there: whether each agent is present, (T, N).
    """
    steps, agents = there.shape
    first = (contacts[:, 0] - 1) * agents
    # One graph for all steps: the agents of different steps are different nodes.
    labels = _components(steps * agents, first + contacts[:, 1], first + contacts[:, 2])
    sizes = np.bincount(labels, minlength=1)[labels].reshape(steps, agents).astype(np.float64)
    sizes, present = np.where(there, sizes, 0), np.maximum(there.sum(axis=1), 1)
    grouped = np.where(sizes > 1, 1 / np.maximum(sizes, 1), 0.0).sum(axis=1)
    return np.column_stack([sizes.max(axis=1) / present, np.round(grouped)])
