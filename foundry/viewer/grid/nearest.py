"""How near agents of a 2D world are to one another, against agents put anywhere at random."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

_NEVER = 1e-9
"""A chance that no agent is within a distance which is taken for none."""


def nearest_index(cells: Sequence[tuple[int, int]], side: int) -> float | None:
    """Return the mean distance to the nearest other agent over what is expected at random; None for fewer than two.

    0 when all stand in pairs, 1 at random, above that when they keep apart. Source: Clark and Evans 1954; the
    expectation is the exact one for cells of a grid, edges included, and not their formula for points on a plane.

    Args:
        cells: the cell of each agent, (x, y).
        side: cells along each axis of the grid.
    """
    if len(cells) < 2:
        return None
    from scipy.spatial import cKDTree

    points = np.array(cells, dtype=np.float64)
    distances = np.asarray(cKDTree(points).query(points, k=2)[0])
    return float(distances[:, 1].mean() / expected_nearest(len(cells), side))


@lru_cache(maxsize=64)
def expected_nearest(agents: int, side: int) -> float:
    """Return the expected Euclidean distance to the nearest of all other agents, cells, each put into any cell alike.

    It is the mean over cells of the sum over distances d of (1 - share of cells within d) ** (agents - 1) times the gap
    to the next distance, since that is the chance of nobody within d.
    """
    reach = _reach(agents, side)
    total = 0.0
    for left, down, count in _kinds_of_cells(side, reach):
        squared = _squared(left, side, reach)[:, None] + _squared(down, side, reach)[None, :]
        within = np.cumsum(np.bincount(squared.ravel(), minlength=2)) / side**2
        alone = (1 - np.minimum(within, 1)) ** (agents - 1)
        total += count * float((alone[:-1] * np.diff(np.sqrt(np.arange(len(within))))).sum())
    return total / side**2


def _reach(agents: int, side: int) -> int:
    """Return a distance, cells, within which there surely is another agent, even of one in a corner."""
    share = 1 - _NEVER ** (1 / (agents - 1))
    return min(side - 1, int(np.ceil(2 * side * np.sqrt(share / np.pi))) + 2)


def _kinds_of_cells(side: int, reach: int) -> Iterator[tuple[int, int, int]]:
    """Yield the cells of one octant by their distance to the edges, and how many of the grid are like each."""
    half = (side + 1) // 2
    alike = [1 if 2 * at + 1 == side else 2 for at in range(half)]
    inner = min(half, reach + 1)
    counts = [*alike[: inner - 1], sum(alike[inner - 1 :])]
    for left, wide in enumerate(counts):
        for down in range(left + 1):
            yield left, down, wide * counts[down] * (1 if down == left else 2)


def _squared(at: int, side: int, reach: int) -> NDArray[np.int64]:
    """Return the squared distances along an axis from one of its cells to those within reach."""
    return (np.arange(max(0, at - reach), min(side, at + reach + 1)) - at) ** 2
