"""Path efficiency: how directly agents walked to the place they ended in, or to the target they were to find."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from analysis.camera_run import CameraRun
from analysis.described import Measure, share
from analysis.formulas import mean, ratio
from analysis.paths import ndtw, resampled, soft_spl, spl, steps_to, straightness
from analysis.run import OUTSIDE, GridRun, GridSettings, IntArray

NAME = "path_efficiency"

MEASURES = {
    "trip_efficiency": share("Trip efficiency, waits included"),
    "trip_efficiency_moving": share("Trip efficiency, moves alone"),
    "arrived": share("Agents that end in a place (share)"),
    "success": share("Found the target and stayed there (share)"),
    "reached": share("Target reached at the end (share)"),
    "oracle_success": share("Target reached at any time (share)"),
    "spl": share("Success weighted by path length (SPL)"),
    "oracle_spl": share("Best SPL of any stop on the way (oracle SPL)"),
    "soft_spl": share("Progress weighted by path length (SoftSPL)"),
    "ndtw": share("Likeness to the shortest path (nDTW)"),
    "distance_to_goal": Measure("Distance to the goal at the end (m)", low=0),
    "path_length": Measure("Way covered towards a target (m)", low=0),
    "shortest": Measure("Shortest way to the target (m)", low=0),
    "straightness": share("Straightness of the way"),
}

HEADLINE = ("trip_efficiency", "trip_efficiency_moving", "arrived", "success", "spl", "soft_spl", "distance_to_goal")

SPACING_M = 0.25
"""Distance of the points in which paths are compared, metres: a step of the benchmarks that nDTW comes from."""


@dataclass(frozen=True)
class Trip:
    """One agent's way to a place.

    Attributes:
        agent: the agent.
        start: state in which it was last in the place it left, or 0 if it began outside.
        end: first state in which it is in the place it enters.
        shortest: fewest steps in which that place can be reached from where it started.
    """

    agent: int
    start: int
    end: int
    shortest: int


def measure(run: GridRun) -> dict[str, float]:
    """Return the path efficiency of a run.

    A trip leads from where an agent leaves a place, or from its first state if that is outside, to where it next
    enters another place. Ways back into the place that was left are returns, not trips; ways that end outside are
    neither. l is the fewest steps from the trip's first cell to the place it entered: the geodesic on the grid, around
    whatever cannot be entered.

    - trip_efficiency: l / decisions taken, waits included; mean over trips; above 0..1.
    - trip_efficiency_moving: l / changes of position; mean over trips; above 0..1.
    - arrived: agents in a place at state T / N; 0..1.

    The efficiencies are NaN when there is no trip. They know nothing of agents that never arrive, so show
    `arrived` beside them. Denominators: n_trips, n_returns, n_agents.
    """
    trips, returns = find_trips(run)
    waited = [int(run.counted[trip.start : trip.end, trip.agent].sum()) for trip in trips]
    moved = [int(run.moved[trip.start : trip.end, trip.agent].sum()) for trip in trips]
    return {
        "trip_efficiency": mean(trip.shortest / steps for trip, steps in zip(trips, waited, strict=True)),
        "trip_efficiency_moving": mean(trip.shortest / steps for trip, steps in zip(trips, moved, strict=True)),
        "arrived": ratio(int((run.place[-1] != OUTSIDE).sum()), run.agents),
        "n_trips": float(len(trips)),
        "n_returns": float(returns),
        "n_agents": float(run.agents),
    }


def measure_camera(run: CameraRun) -> dict[str, float]:
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


def find_trips(run: GridRun) -> tuple[list[Trip], int]:
    """Return the trips of a run by agent, and the number of returns."""
    trips, returns = [], 0
    for agent in range(run.agents):
        # The states where the place changes, and the first: between two of them the agent stays in one place, or out.
        places = run.place[:, agent]
        changes = [0, *(np.flatnonzero(np.diff(places)) + 1).tolist()]
        left, start = OUTSIDE, 0
        for change, following in zip(changes, [*changes[1:], len(places)], strict=True):
            entered = int(places[change])
            if entered == OUTSIDE:
                continue
            if change and entered != left:
                trips.append(Trip(agent, start, change, _shortest(run, agent, start, entered)))
            returns += entered == left
            left, start = entered, following - 1
    return trips, returns


def _shortest(run: GridRun, agent: int, state: int, place: int) -> int:
    half = run.world.half_size
    return int(_steps_to(run.world, place)[run.x[state, agent] + half, run.y[state, agent] + half])


@lru_cache(maxsize=64)
def _steps_to(world: GridSettings, place: int) -> IntArray:
    """Return the steps from every cell to a place, (W, W), x first: every cell of these worlds can be entered."""
    edge = np.arange(-world.half_size, world.half_size + 1)
    x, y = np.meshgrid(edge, edge, indexing="ij")
    (left, bottom), (right, top) = world.places[place].low, world.places[place].high
    inside = (x >= left) & (x <= right) & (y >= bottom) & (y <= top)
    return steps_to(inside, np.ones_like(inside))
