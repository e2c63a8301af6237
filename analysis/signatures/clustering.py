"""Clustering: how close together the agents are, and who can hear whom.

The start, state 0, never counts: it is drawn by the world, not chosen by the model.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from analysis.described import Measure, share
from analysis.formulas import mean
from analysis.run import FloatArray, GridRun, IntArray

NAME = "clustering"

MEASURES = {
    "nni_donnelly": Measure("Nearest-neighbour index (1: random)", low=0),
    "nni_naive": Measure("Nearest-neighbour index, no edge correction", low=0),
    "largest_group": share("Largest group (share of agents)"),
    "groups": Measure("Groups of two or more", low=0),
    "isolated": share("Agents with nobody in reach (share)"),
}

HEADLINE = ("nni_donnelly", "largest_group", "isolated")

_DONNELLY = (0.0514, 0.0412)


def measure(run: GridRun) -> dict[str, float]:
    """Return the clustering of a run; all measures are NaN with fewer than two agents.

    - nni_donnelly: Clark-Evans index R = d_obs / d_exp, d_obs the mean Euclidean distance to the nearest other
      agent, d_exp its expectation under randomness with Donnelly's edge correction for rectangles; the window
      is the grid, area W*H. Mean over states 1..T. No unit; 0 (all in one cell) up; below 1 clustered.
      Source: Clark and Evans 1954, Donnelly 1978.
    - nni_naive: the same without the correction; about 1.1 to 1.25 under randomness on small grids.
    - largest_group: agents in the largest connected component of the graph of recorded neighbours / N.
      Mean over states 1..T-1, for which neighbours are recorded; 1/N..1.
    - groups: number of components with two agents or more, same mean; 0..N/2.
    - isolated: share of agents without neighbours, same mean; 0..1.

    Denominators: n_states (of the indices), n_group_states (of the groups; NaN there when it is 0).
    """
    if run.agents < 2:
        return dict.fromkeys(MEASURES, math.nan) | {"n_states": 0.0, "n_group_states": 0.0}
    observed = mean(_mean_distance(run.x[state], run.y[state]) for state in range(1, run.steps + 1))
    side = run.world.width
    groups = group_shape(run.contacts, run.steps, run.agents)[1:]
    return {
        "nni_donnelly": observed / expected_distance(run.agents, side, side),
        "nni_naive": observed / expected_distance(run.agents, side, side, corrected=False),
        "largest_group": mean(groups[:, 0]),
        "groups": mean(groups[:, 1]),
        "isolated": mean(groups[:, 2]),
        "n_states": float(run.steps),
        "n_group_states": float(len(groups)),
    }


def nearest_distances(x: IntArray, y: IntArray) -> FloatArray:
    """Return each agent's Euclidean distance to the nearest other one, cells; x, y, result (N,), N >= 2."""
    squared = (x[:, None] - x) ** 2 + (y[:, None] - y) ** 2
    np.fill_diagonal(squared, np.iinfo(np.int64).max)
    nearest: FloatArray = np.sqrt(squared.min(axis=1).astype(np.float64))
    return nearest


def _mean_distance(x: IntArray, y: IntArray) -> float:
    return mean(nearest_distances(x, y))


def expected_distance(agents: int, width: float, height: float, *, corrected: bool = True) -> float:
    """Return the mean nearest-neighbour distance of random points in a rectangle, Donnelly's if corrected."""
    naive = 0.5 * math.sqrt(width * height / agents)
    if not corrected:
        return naive
    constant, per_root = _DONNELLY
    return naive + (constant + per_root / math.sqrt(agents)) * 2 * (width + height) / agents


def group_shape(contacts: IntArray, steps: int, agents: int) -> FloatArray:
    """Return the groups before each step's move.

    Args:
        contacts: rows (1-based step, agent, neighbour), (K, 3).
        steps: number of steps, T.
        agents: number of agents, N.

    Returns:
        (T, 3): largest component / N, components of two or more, isolated agents / N.
    """
    count = steps * agents
    first = (contacts[:, 0] - 1) * agents
    ends = (first + contacts[:, 1], first + contacts[:, 2])
    # One graph for all steps: the agents of different steps are different nodes.
    graph = coo_array((np.ones(len(contacts), dtype=np.int8), ends), shape=(count, count))
    labels = connected_components(graph, directed=False)[1]
    sizes = np.bincount(labels, minlength=1)[labels].reshape(steps, agents).astype(np.float64)
    grouped = np.where(sizes > 1, 1 / sizes, 0.0).sum(axis=1)
    isolated = (sizes == 1).sum(axis=1)
    return np.column_stack([sizes.max(axis=1) / agents, np.round(grouped), isolated / agents])
