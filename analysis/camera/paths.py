"""Formulas of paths in space: how long, how straight, how like another; undefined is NaN."""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import FloatArray
from analysis.camera.camera_run import STILL_M


def spl(success: float, shortest: float, length: float) -> float:
    """Return success weighted by path length, 0..1; NaN when the shortest way is 0, infinite or unknown.

    Args:
        success: 1 if the episode succeeded, else 0.
        shortest: length of the shortest way, l.
        length: length of the way taken, p.
    """
    return success * efficiency(shortest, length)


def soft_spl(remaining: float, shortest: float, length: float) -> float:
    """Return the progress towards the goal, weighted by path length, 0..1; `remaining` is the distance at the end."""
    efficient = efficiency(shortest, length)
    return max(0.0, 1 - remaining / shortest) * efficient if not math.isnan(efficient + remaining) else math.nan


def efficiency(shortest: float, length: float) -> float:
    """Return l / max(l, p), 0..1; NaN when the shortest way l is 0, infinite or unknown."""
    return shortest / max(shortest, length) if 0 < shortest < math.inf else math.nan


def straightness(path: FloatArray, length: float) -> float:
    """Return the net displacement of a path (k, 2) over its length, 0..1; NaN for a length below a millimetre."""
    if length < STILL_M:
        return math.nan
    return min(math.dist(path[0], path[-1]) / length, 1.0)


def resampled(path: FloatArray, spacing: float) -> FloatArray:
    """Return points spread evenly along a path (k, 2), at most `spacing` apart, both ends included, (n, 2)."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    places = np.linspace(0.0, along[-1], math.ceil(along[-1] / spacing) + 1)
    return np.column_stack([np.interp(places, along, axis) for axis in path.T])


def ndtw(path: FloatArray, reference: FloatArray, threshold: float) -> float:
    """Return normalised dynamic time warping, exp(-DTW / (|R| threshold)), 0..1 (1: the same path).

    Args:
        path: points of the path taken, (n, 2).
        reference: points of the path that it is compared with, R, (m, 2).
        threshold: distance that counts as near.
    """
    return math.exp(-_dtw(path, reference) / (len(reference) * threshold)) if threshold > 0 else math.nan


def _dtw(first: FloatArray, second: FloatArray) -> float:
    """Return the least sum of distances over all monotonous alignments of two rows of points, ends included."""
    best = np.full(len(second), math.inf)
    for number, point in enumerate(first):
        costs = np.linalg.norm(second - point, axis=1)
        # The cheapest way into each cell from the row above, then along the row: a running minimum of what is left
        # when the costs up to there are taken off.
        above = np.minimum(best, np.concatenate([[math.inf if number else 0.0], best[:-1]]))
        sums = np.cumsum(costs)
        best = np.minimum.accumulate(above - (sums - costs)) + sums
    return float(best[-1])
