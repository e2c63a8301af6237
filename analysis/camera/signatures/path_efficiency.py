"""Path efficiency: how directly an agent walked to its target."""

from __future__ import annotations

import math

import numpy as np

from analysis.camera.camera_run import CameraRun
from analysis.camera.paths import ndtw, resampled, soft_spl, spl, straightness
from analysis.measure import HIGH, LOW, Measure, outcome, share

NAME = "path_efficiency"

MEASURES = {
    "success": outcome(
        "Found the target and stayed there (share)", better=HIGH, says="finds its target {more|less} often"
    ),
    "reached": outcome("Target reached at the end (share)", better=HIGH),
    "oracle_success": outcome("Target reached at any time (share)", better=HIGH),
    "spl": share("Success weighted by path length (SPL)", better=HIGH),
    "oracle_spl": share("Best SPL of any stop on the way (oracle SPL)", better=HIGH),
    "soft_spl": share("Progress weighted by path length (SoftSPL)", better=HIGH),
    "ndtw": share("Likeness to the shortest path (nDTW)", better=HIGH),
    "distance_to_goal": Measure("Distance to the goal at the end (m)", low=0, better=LOW),
    "path_length": Measure("Way covered towards a target (m)", low=0),
    "shortest": Measure("Shortest way to the target (m)", low=0),
    "straightness": share("Straightness of the way"),
}

HEADLINE = ("success", "spl", "soft_spl", "distance_to_goal")

SPACING_M = 0.25
"""Distance of the points in which paths are compared, metres: a step of the benchmarks that nDTW comes from."""


def measure(run: CameraRun) -> dict[str, float]:
    """Return the path efficiency of a run of a 3D world; all measures are NaN without a target.

    l is the length of the shortest way from the start to the goal, p that of the way covered: blocked moves add
    nothing, slides what they cover. The goal is reached where the foot is within the target's radius and the target
    is in view. Distances are geodesic; a wall is gone around. All are seen from above.

    - success: S, 1 if the goal is reached at the end and the last decision was to stay, by the agent's own word;
      else 0. NaN without decisions, as the next two.
    - reached: 1 if the goal is reached at the end, whether or not the agent stayed; else 0.
    - oracle_success: 1 if the goal was reached after any decision; else 0.
    - spl: S l / max(l, p); 0..1. NaN when there is no way, or l = 0. Source: Anderson et al. 2018.
    - oracle_spl: l / max(l, p up to where the goal was first reached), 0 if it never was: the SPL of the best moment
      to stop. NaN as spl.
    - soft_spl: max(0, 1 - d / l) l / max(l, p), d the distance to the goal at the end; 0..1. NaN as spl, or when d is
      unknown. Source: habitat-lab.
    - ndtw: exp(-DTW / (|R| d_th)); R is the shortest path, both paths have points every SPACING_M metres, d_th is the
      target's radius; 0..1. NaN when there is no way. Source: Ilharco et al. 2019.
    - distance_to_goal: d, metres; 0 up. NaN when the goal cannot be reached from there.
    - path_length, shortest: p and l, metres.
    - straightness: distance between start and end / p; 0..1. NaN when p is below a millimetre.

    Denominators: n_decisions, n_episodes (1 with a target, else 0).
    """
    found = _camera_measures(run)
    return {
        **(found if run.has_target else dict.fromkeys(found, math.nan)),
        "n_decisions": float(run.counted.sum()),
        "n_episodes": float(run.has_target),
    }


def _camera_measures(run: CameraRun) -> dict[str, float]:
    shortest = math.nan if run.episode.shortest_m is None else run.episode.shortest_m
    length, remaining = run.path_length, float(run.distance[-1])
    # The way covered when the goal was first reached; it only grows, so no later moment is better.
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
    """Return how like the way is to the shortest one, or NaN when there is none."""
    if not run.episode.shortest_path:
        return math.nan
    reference = np.array(run.episode.shortest_path)[:, :2]
    return ndtw(resampled(run.foot[:, :2], SPACING_M), resampled(reference, SPACING_M), run.episode.radius)
