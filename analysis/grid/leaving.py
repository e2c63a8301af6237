"""How agents leave a 2D world: the shortest ways to its exits, and the soonest that so many could be out."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from analysis.arrays import FloatArray, IntArray
from analysis.grid.distances import steps_to
from analysis.grid.grid_run import GridRun, GridSettings
from foundry.leaving import FAR, soonest_departures

NO_WAY = -1


@lru_cache(maxsize=16)
def exit_steps(world: GridSettings) -> IntArray:
    """Return the fewest steps to each exit from every cell, NO_WAY where there is none; x first, (E, W, W).

    Ways lead round walls and through no other exit; whoever moves onto a cell of an exit is out.
    """
    half = world.half_size
    fields = []
    for own in world.exits:
        free, goal = world.free(), np.zeros((world.width, world.width), dtype=np.bool_)
        for one in world.exits:
            for x, y in one.cells:
                free[x + half, y + half] = one is own
        for x, y in own.cells:
            goal[x + half, y + half] = True
        fields.append(steps_to(goal, free))
    return np.array(fields, dtype=np.int64).reshape(-1, world.width, world.width)


def start_distances(run: GridRun) -> IntArray:
    """Return the fewest steps to each exit from where each agent starts, NO_WAY where there is no way, (E, N)."""
    half = run.world.half_size
    return exit_steps(run.world)[:, run.x[0] + half, run.y[0] + half]


def soonest(run: GridRun) -> FloatArray:
    """Return the first step by the end of which 1, 2, ... agents of the start can be out, inf where so many never can.

    It is a lower bound for every policy, (N,): in each step no more go through an exit than it lets out, and nobody is
    there sooner than on a shortest way; crowds, fires and not knowing the way only take longer.
    """
    distances = start_distances(run)[:, : run.world.agents].T
    far = np.where(distances == NO_WAY, FAR, distances).tolist()
    found = soonest_departures(far, [one.capacity for one in run.world.exits])
    return np.sort([np.inf if one is None else float(one.step) for one in found])
