"""Recovery: how often an agent of a 3D world moves away from its goal, and whether it comes back."""

import math
from dataclasses import dataclass

import numpy as np

from analysis.arrays import BoolArray, FloatArray
from analysis.camera.camera_run import STILL_M, CameraRun
from analysis.formulas import mean, ratio, restricted_mean
from analysis.measure import Measure, share

NAME = "recovery"

HORIZON = 10
"""Maximum number of decisions of a detour that count in the mean time to recovery, so that long runs and short runs
can be compared.
"""

MEASURES = {
    "wrong_rate": share(
        "Decisions that lead away from the goal (share)", says="goes away from its goal {more|less} often"
    ),
    "recovered": share("Detours recovered (share)", says="recovers {more|fewer} of its detours"),
    "time": Measure("Decisions until recovery from a detour", low=1),
    "rmst": Measure("Mean time to recovery (decisions, restricted)", 1, HORIZON),
    "max_excess": Measure("Greatest detour (m)", low=0),
    "detour_cost": Measure("Extra path beyond the shortest (share of the shortest)", low=-1),
}

HEADLINE = ("wrong_rate", "recovered", "rmst", "max_excess", "detour_cost")


@dataclass(frozen=True)
class Detour:
    """A detour: decisions from a step away from the goal until the distance is as before, or until the run ends.

    Attributes:
        steps: decisions until the distance is back to its value before the detour, or until the end of the run.
        recovered: whether the distance came back to that value.
        excess: greatest distance in the detour minus the distance before it, metres.
    """

    steps: int
    recovered: bool
    excess: float


def measure(run: CameraRun) -> dict[str, float]:
    """Return the recovery of a run from wrong decisions.

    g(t) is the length of the shortest path to the goal at state t, metres. States with an unknown distance and states
    after uncounted decisions are left out. A decision is wrong if g grows by STILL_M or more. Turning is never wrong,
    because it does not change g. A detour opens at a wrong decision, and its base is g before this decision. A detour
    closes at the first state with g less than STILL_M above the base. A detour that is open at the end is
    right-censored.

    - wrong_rate: wrong decisions / decisions; 0..1.
    - recovered: closed detours / detours; 0..1. NaN without detours. Detours that open late lower this share.
    - time: mean number of decisions of closed detours, without open ones; 1 up. NaN without closed detours.
    - rmst: restricted mean time to recovery, decisions, 1..HORIZON: area under the Kaplan-Meier curve of all detours up
      to HORIZON, open ones censored. NaN without detours. A low value means fast recovery. Source: Kaplan and Meier
      1958.
    - max_excess: greatest g on a detour minus its base, metres; 0 up. NaN without detours.
    - detour_cost: (p - l) / l, with p the length of the path and l the shortest; -1 up. NaN unless the goal is reached
      at the end. A stop within the radius can make it slightly negative.

    All are NaN without a target. 2D worlds have no such signature, because their records declare no goals of agents.
    Denominators: n_steps, n_wrong, n_detours, n_recovered.
    """
    known = _known_distances(run)
    wrong, detours = wrong_steps(known), find_detours(known)
    times = np.array([detour.steps for detour in detours], dtype=np.int64)
    closed = np.array([detour.recovered for detour in detours], dtype=np.bool_)
    shortest = run.episode.shortest_m or 0.0
    reached = run.has_target and bool(run.success[-1:].any())
    return {
        "wrong_rate": mean(wrong),
        "recovered": mean(closed),
        "time": mean(times[closed]),
        "rmst": restricted_mean(times, closed, HORIZON),
        "max_excess": max((detour.excess for detour in detours), default=math.nan),
        "detour_cost": ratio(run.path_length - shortest, shortest) if reached else math.nan,
        "n_steps": float(len(wrong)),
        "n_wrong": float(wrong.sum()),
        "n_detours": float(len(detours)),
        "n_recovered": float(closed.sum()),
    }


def _known_distances(run: CameraRun) -> FloatArray:
    """Return the distance to the goal at the start and after each counted decision, metres, (n,); NaN is left out."""
    if not run.has_target:
        return run.distance[:0]
    known = run.distance[np.concatenate(([True], run.counted))]
    return known[~np.isnan(known)]


def wrong_steps(distances: FloatArray) -> BoolArray:
    """Return whether each step leads away from the goal, (n - 1,).

    Args:
        distances: distance to the goal at the start and after each step, metres, (n,).
    """
    return np.asarray(np.diff(distances) >= STILL_M)


def find_detours(distances: FloatArray) -> list[Detour]:
    """Return the detours (sequences of steps that begin with a step away from the goal), in order.

    Args:
        distances: distance to the goal at the start and after each step, metres, (n,).
    """
    wrong, detours, state = wrong_steps(distances), [], 0
    while state < len(wrong):
        if not wrong[state]:
            state += 1
            continue
        later = distances[state + 1 :] - distances[state]
        back = np.flatnonzero(later < STILL_M)
        steps = int(back[0]) if len(back) else len(later)
        detours.append(Detour(steps, bool(len(back)), float(later[:steps].max())))
        state += steps + 1 if len(back) else len(wrong)
    return detours
