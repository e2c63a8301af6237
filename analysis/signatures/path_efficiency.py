"""Path efficiency: how directly agents walked to the place they ended in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.described import share
from analysis.formulas import mean, ratio
from analysis.run import OUTSIDE, GridRun, Place

NAME = "path_efficiency"

MEASURES = {
    "trip_efficiency": share("Trip efficiency, waits included"),
    "trip_efficiency_moving": share("Trip efficiency, moves alone"),
    "arrived": share("Agents that end in a place (share)"),
}

HEADLINE = ("trip_efficiency", "trip_efficiency_moving", "arrived")


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
