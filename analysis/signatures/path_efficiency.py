"""Path efficiency: how directly agents walked to the place they ended in, or to the target they were to find."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analysis.camera_run import CameraRun
from analysis.described import Measure, share
from analysis.formulas import mean, ratio
from analysis.paths import ndtw, resampled, soft_spl, spl, straightness
from analysis.run import OUTSIDE, GridRun, Place

NAME = "path_efficiency"

MEASURES = {
    "trip_efficiency": share("Trip efficiency, waits included"),
    "trip_efficiency_moving": share("Trip efficiency, moves alone"),
    "arrived": share("Agents that end in a place (share)"),
    "success": share("Found the target and stayed there (share)"),
    "reached": share("Target reached at the end (share)"),
    "oracle_success": share("Target reached at any time (share)"),
    "spl": share("Success weighted by path length (SPL)"),
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
        shortest: fewest steps in which the place can be reached from the start.
        steps: steps until it first entered the place, waits included.
        moves: changes of position among them.
    """

    shortest: int
    steps: int
    moves: int


def measure(run: GridRun) -> dict[str, float]:
    """Return the path efficiency of a run.

    A trip belongs to an agent that is in a place at state T and did not start in that place. It leads from
    state 0 to the first state in which the agent is in that very place; detours, also through other places, are
    part of it, and what comes after is not. l is the fewest steps of such a way: the Manhattan distance from
    the start to the nearest cell of the place. That is the exact geodesic here, since moves go to the four
    adjacent cells, places are rectangles of cells that can be entered anywhere, and nothing stands in the way:
    no walls, no capacity that is enforced, no agent that blocks another.

    - trip_efficiency: l / steps taken, waits included; mean over trips; above 0..1.
    - trip_efficiency_moving: l / changes of position; mean over trips; above 0..1.
    - arrived: agents in a place at state T / N; 0..1.

    The efficiencies are NaN when there is no trip. They know nothing of agents that never arrive, so show
    `arrived` beside them. Denominators: n_trips, n_agents.
    """
    trips = find_trips(run)
    return {
        "trip_efficiency": mean(trip.shortest / trip.steps for trip in trips),
        "trip_efficiency_moving": mean(trip.shortest / trip.moves for trip in trips),
        "arrived": ratio(int((run.place[-1] != OUTSIDE).sum()), run.agents),
        "n_trips": float(len(trips)),
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
        "n_decisions": float(run.decisions),
        "n_episodes": float(run.has_target),
    }


def _camera_measures(run: CameraRun) -> dict[str, float]:
    shortest = math.nan if run.episode.shortest_m is None else run.episode.shortest_m
    length, remaining = run.path_length, float(run.distance[-1])
    stayed = bool((run.stay & run.readable)[-1:].any())
    reached = float(run.success[-1]) if run.decisions else math.nan
    success = reached * stayed
    return {
        "success": success,
        "reached": reached,
        "oracle_success": float(run.success.any()) if run.decisions else math.nan,
        "spl": spl(success, shortest, length),
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


def find_trips(run: GridRun) -> list[Trip]:
    """Return the trips of a run by agent."""
    trips = []
    for agent in np.flatnonzero((run.place[-1] != OUTSIDE) & (run.place[-1] != run.place[0])).tolist():
        index = int(run.place[-1, agent])
        steps = int((run.place[:, agent] == index).argmax())
        start = (int(run.x[0, agent]), int(run.y[0, agent]))
        moves = int(run.moved[:steps, agent].sum())
        trips.append(Trip(distance_to(run.world.places[index], start), steps, moves))
    return trips


def distance_to(place: Place, cell: tuple[int, int]) -> int:
    """Return the Manhattan distance from a cell to the nearest cell of a place; 0 inside."""
    gaps = [max(low - at, 0, at - high) for at, low, high in zip(cell, place.low, place.high, strict=True)]
    return sum(gaps)
