"""Path efficiency: how directly an agent walked to its target."""

import math

import numpy as np

from analysis.arrays import FloatArray
from analysis.camera.camera_run import STILL_M, CameraRun
from analysis.measure import HIGH, LOW, Measure, outcome, share


def spl(success: float, shortest: float, length: float) -> float:
    """Return success (0 or 1) weighted by path length, 0..1; NaN if the shortest path is 0, infinite or unknown."""
    return success * efficiency(shortest, length)


def soft_spl(remaining: float, shortest: float, length: float) -> float:
    """Return the progress towards the goal, weighted by path length, 0..1; `remaining` is the distance at the end."""
    efficient = efficiency(shortest, length)
    return max(0.0, 1 - remaining / shortest) * efficient if not math.isnan(efficient + remaining) else math.nan


def efficiency(shortest: float, length: float) -> float:
    """Return l / max(l, p), 0..1, with l the shortest path and p the path; NaN if l is 0, infinite or unknown."""
    return shortest / max(shortest, length) if 0 < shortest < math.inf else math.nan


def straightness(path: FloatArray, length: float) -> float:
    """Return the distance between the ends of a path (k, 2), divided by its length, 0..1; NaN below a millimetre."""
    if length < STILL_M:
        return math.nan
    return min(math.dist(path[0], path[-1]) / length, 1.0)


def resampled(path: FloatArray, spacing: float) -> FloatArray:
    """Return evenly spaced points along a path (k, 2), at most `spacing` apart, with both ends, (n, 2)."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    places = np.linspace(0.0, along[-1], math.ceil(along[-1] / spacing) + 1)
    return np.column_stack([np.interp(places, along, axis) for axis in path.T])


def ndtw(path: FloatArray, reference: FloatArray, threshold: float) -> float:
    """Return normalised dynamic time warping (nDTW) of two paths, exp(-DTW / (|R| threshold)); 0..1, 1: the same path.

    Args:
        path: points of the actual path, (n, 2).
        reference: points of the reference path, R, (m, 2).
        threshold: distance that counts as near.
    """
    return math.exp(-_dtw(path, reference) / (len(reference) * threshold)) if threshold > 0 else math.nan


def _dtw(first: FloatArray, second: FloatArray) -> float:
    """Align the points of two paths in order, and return the smallest possible sum of distances of aligned points."""
    best = np.full(len(second), math.inf)
    for number, point in enumerate(first):
        costs = np.linalg.norm(second - point, axis=1)
        # The cheapest path into each cell comes from the row above, then along the row: a running minimum of the
        # remaining cost after subtracting the cumulative cost.
        above = np.minimum(best, np.concatenate([[math.inf if number else 0.0], best[:-1]]))
        sums = np.cumsum(costs)
        best = np.minimum.accumulate(above - (sums - costs)) + sums
    return float(best[-1])


NAME = "path_efficiency"

MEASURES = {
    "success": outcome(
        "Found the target and stayed there (share)", better=HIGH, says="finds its target {more|less} often"
    ),
    "reached": outcome("Target reached at the end (share)", better=HIGH),
    "oracle_success": outcome("Target reached at any time (share)", better=HIGH),
    "spl": share("Success weighted by path length (SPL)", better=HIGH),
    "oracle_spl": share("Best SPL of any stop on the path (oracle SPL)", better=HIGH),
    "soft_spl": share("Progress weighted by path length (SoftSPL)", better=HIGH),
    "ndtw": share("Likeness to the shortest path (nDTW)", better=HIGH),
    "distance_to_goal": Measure("Distance to the goal at the end (m)", low=0, better=LOW),
    "path_length": Measure("Length of the path towards a target (m)", low=0),
    "shortest": Measure("Shortest path to the target (m)", low=0),
    "straightness": share("Straightness of the path"),
}

HEADLINE = ("success", "spl", "soft_spl", "distance_to_goal")

SPACING_M = 0.25
"""Spacing of the points in comparisons of paths, metres; benchmarks that use nDTW have steps of this length."""


def measure(run: CameraRun) -> dict[str, float]:
    """Return the path efficiency of a run of a 3D world; all measures are NaN without a target.

    l is the length of the shortest path from the start to the goal, p the length of the actual path. Blocked moves add
    nothing to p; slides add the covered distance. The goal is reached if the foot is within the target's radius and the
    target is in view. Distances are geodesic, around walls. All are seen from above.

    - success: S, 1 if the goal is reached at the end and the last decision is to stay; else 0. success, reached and
      oracle_success are NaN without decisions.
    - reached: 1 if the goal is reached at the end, whether or not the agent stayed; else 0.
    - oracle_success: 1 if the goal was reached after any decision; else 0.
    - spl: S l / max(l, p); 0..1. NaN if no path exists, or l = 0. Source: Anderson et al. 2018.
    - oracle_spl: l / max(l, p until the goal is first reached), 0 if it never is: the SPL for stopping at the best
      moment. NaN where spl is NaN.
    - soft_spl: max(0, 1 - d / l) l / max(l, p), with d the distance to the goal at the end; 0..1. NaN where spl is NaN,
      or if d is unknown. Source: habitat-lab.
    - ndtw: exp(-DTW / (|R| d_th)); 0..1. R is the shortest path, d_th the target's radius; both paths have points every
      SPACING_M metres. NaN if no path exists. Source: Ilharco et al. 2019.
    - distance_to_goal: d, metres; 0 up. NaN if the goal is unreachable from the last position.
    - path_length: p, metres. shortest: l, metres.
    - straightness: distance between start and end / p; 0..1. NaN when p is below a millimetre.

    Denominators: n_decisions, n_episodes (1 with a target, else 0).
    """
    measures = _camera_measures(run)
    return {
        **(measures if run.has_target else dict.fromkeys(measures, math.nan)),
        "n_decisions": float(run.counted.sum()),
        "n_episodes": float(run.has_target),
    }


def _camera_measures(run: CameraRun) -> dict[str, float]:
    shortest = math.nan if run.episode.shortest_m is None else run.episode.shortest_m
    length, remaining = run.path_length, float(run.distance[-1])
    # The path length when the goal is first reached. The length only grows, so no later moment is better.
    length_there = float(run.travelled[: int(run.success.argmax()) + 1].sum()) if run.success.any() else length
    stayed = bool((run.stay & run.readable)[-1:].any())
    decided = bool(run.counted.any())
    reached = float(run.success[-1]) if decided else math.nan
    ever = float(run.success.any()) if decided else math.nan
    success = reached * stayed
    return {
        "success": success,
        "reached": reached,
        "oracle_success": ever,
        "spl": spl(success, shortest, length),
        "oracle_spl": spl(ever, shortest, length_there),
        "soft_spl": soft_spl(remaining, shortest, length),
        "ndtw": _likeness(run),
        "distance_to_goal": remaining,
        "path_length": length,
        "shortest": shortest,
        "straightness": straightness(run.foot[:, :2], length),
    }


def _likeness(run: CameraRun) -> float:
    """Return how similar the path is to the shortest path (nDTW); NaN if no path exists."""
    if not run.episode.shortest_path:
        return math.nan
    reference = np.array(run.episode.shortest_path)[:, :2]
    return ndtw(resampled(run.foot[:, :2], SPACING_M), resampled(reference, SPACING_M), run.episode.radius)
