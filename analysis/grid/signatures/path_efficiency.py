"""Path efficiency: how directly agents walked to the places that they entered."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from analysis.arrays import IntArray
from analysis.formulas import mean, ratio
from analysis.grid.distances import steps_to
from analysis.grid.grid_run import OUTSIDE, GridRun, GridSettings
from analysis.measure import share

NAME = "path_efficiency"

MEASURES = {
    "trip_efficiency": share(
        "Shortest path to a place / steps taken, waits included", says="goes to places {more|less} directly"
    ),
    "trip_efficiency_moving": share("Shortest path to a place / moves made"),
    "arrived": share("Agents that end in a place (share)"),
}

HEADLINE = ("trip_efficiency", "trip_efficiency_moving", "arrived")


@dataclass(frozen=True)
class Trip:
    """An agent's path from one place, or from its first cell, to another place.

    Attributes:
        start: last state in the place that the agent left, or 0 if it began outside.
        end: first state in the place that it entered.
        shortest: fewest steps from its cell at the start to the place that it entered.
    """

    agent: int
    start: int
    end: int
    shortest: int


def measure(run: GridRun) -> dict[str, float]:
    """Return the path efficiency of a run.

    A trip leads from a place that an agent leaves to the next other place that it enters. If the agent begins outside,
    its first trip leads from its first cell. A path back into the same place is a return, not a trip; a path that ends
    outside is neither. l is the fewest steps from the trip's first cell to the entered place, around walls.

    - trip_efficiency: l / decisions taken, waits included; mean over trips; above 0..1.
    - trip_efficiency_moving: l / changes of position; mean over trips; above 0..1.
    - arrived: agents in a place at the end of the run / N; 0..1.

    The efficiencies are NaN without trips. The efficiencies ignore agents that never arrive, so report `arrived` too.
    Denominators: n_trips, n_returns, n_agents.
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


def find_trips(run: GridRun) -> tuple[list[Trip], int]:
    """Return the trips of all agents, and how often an agent came back to the place that it had left."""
    trips, returns, half = [], 0, run.world.half_size
    for agent in range(run.agents):
        # The first state, and the states in which the agent is in another place than before, or outside.
        places = run.place[:, agent]
        changes = [0, *(np.flatnonzero(np.diff(places)) + 1).tolist()]
        left, start = OUTSIDE, 0
        for change, following in zip(changes, [*changes[1:], len(places)], strict=True):
            entered = int(places[change])
            if entered == OUTSIDE:
                continue
            if change and entered != left:
                x, y = run.x[start, agent] + half, run.y[start, agent] + half
                trips.append(Trip(agent, start, change, int(_steps_to(run.world, entered)[x, y])))
            returns += entered == left
            left, start = entered, following - 1
    return trips, returns


@lru_cache(maxsize=64)
def _steps_to(world: GridSettings, place: int) -> IntArray:
    """Return the fewest steps from every cell to a place, around walls, (W, W), indexed by x and y."""
    edge = np.arange(-world.half_size, world.half_size + 1)
    x, y = np.meshgrid(edge, edge, indexing="ij")
    (left, bottom), (right, top) = world.places[place].low, world.places[place].high
    inside = (x >= left) & (x <= right) & (y >= bottom) & (y <= top)
    return steps_to(inside, world.free())
