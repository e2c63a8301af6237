"""Agents on a grid as points: how near they are to one another, and how near random ones would be."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from analysis.arrays import FloatArray, IntArray
from foundry import seeding

DRAWS = 999
"""Random placements that a null is made of."""

_PAIRS = 2**20
"""Pairs of agents that are held at once."""

_SEED = 1954
"""Of every null: the same number comes out in every process and on every machine."""


@dataclass(frozen=True)
class Closeness:
    """How near agents are to one another, by state, (S,) each.

    Attributes:
        nearest: mean over agents of the Euclidean distance to the nearest other one, cells.
        pairs: pairs within the radius / pairs; times the area of the grid it is Ripley's K without edge correction.
        ripley: Ripley's K at the radius, edges corrected by translation, cells squared.
    """

    nearest: FloatArray
    pairs: FloatArray
    ripley: FloatArray


@dataclass(frozen=True)
class Null:
    """What agents put at random come to, over DRAWS placements.

    Attributes:
        nearest: mean of the mean distance to the nearest other one, cells.
        deviation: its standard deviation over the placements, ddof 0.
        besag: mean of Besag's L(r) - r, cells.
    """

    nearest: float
    deviation: float
    besag: float


def closeness(x: IntArray, y: IntArray, side: int, radius: float) -> Closeness:
    """Return how near agents are to one another in each state.

    Args:
        x: columns by state and agent, (S, N), N >= 2.
        y: rows, same shape.
        side: cells along each axis of the grid, which is the window.
        radius: scale of Ripley's K, cells.
    """
    parts = [_closeness(x[part], y[part], side, radius) for part in _parts(*x.shape)]
    return Closeness(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _parts(states: int, agents: int) -> Iterator[slice]:
    size = max(1, _PAIRS // agents**2)
    return (slice(start, start + size) for start in range(0, states, size))


def _closeness(x: IntArray, y: IntArray, side: int, radius: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    x, y = x.astype(np.int32), y.astype(np.int32)
    wide, high = np.abs(x[:, :, None] - x[:, None]), np.abs(y[:, :, None] - y[:, None])
    squared = wide**2 + high**2
    agents = np.arange(x.shape[1])
    squared[:, agents, agents] = np.iinfo(np.int32).max
    nearest = np.sqrt(squared.min(axis=2)).mean(axis=1)
    near = np.flatnonzero(squared <= radius**2)
    # By translation: a pair counts by how much of the window both its ends can be shifted in.
    kept = (side - wide.ravel()[near]) * (side - high.ravel()[near])
    pairs, state = len(agents) * (len(agents) - 1), near // len(agents) ** 2
    weights = np.bincount(state, weights=side**2 / kept, minlength=len(x))
    return nearest, np.bincount(state, minlength=len(x)) / pairs, weights * side**2 / pairs


def besag(ripley: FloatArray, radius: float) -> FloatArray:
    """Return Besag's L(r) - r of Ripley's K at r, cells; same shape. 0 at random, above 0 clustered at that scale."""
    return np.asarray(np.sqrt(ripley / math.pi) - radius)


@lru_cache(maxsize=64)
def random_placements(agents: int, side: int, radius: float) -> Null:
    """Return what agents come to that stand anywhere in the grid, each cell as likely, several in one allowed."""
    rng = seeding.stream(_SEED, "random placements")
    x, y = rng.integers(side, size=(2, DRAWS, agents))
    found = closeness(x, y, side, radius)
    return Null(
        nearest=float(found.nearest.mean()),
        deviation=float(found.nearest.std()),
        besag=float(besag(found.ripley, radius).mean()),
    )
