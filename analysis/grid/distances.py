"""Distances on the grid of a 2D world, from cells to places, fires and agents."""

import numpy as np

from analysis.arrays import BoolArray, FloatArray, IntArray
from analysis.grid.grid_run import GridSettings

_AT_ONCE = 2**15


def to_nearest_place(world: GridSettings, x: IntArray, y: IntArray) -> FloatArray:
    """Return the fewest moves from each cell to the nearest place: 0 inside a place, NaN without places.

    x, y and the result have the same shape. This is the Manhattan distance, which ignores walls.
    """
    nearest: FloatArray = np.full(x.shape, np.nan)
    for place in world.places:
        (left, bottom), (right, top) = place.low, place.high
        across = np.maximum(np.maximum(left - x, x - right), 0)
        np.fmin(nearest, across + np.maximum(np.maximum(bottom - y, y - top), 0), out=nearest)
    return nearest


def to_fires(world: GridSettings, x: IntArray, y: IntArray, *, straight: bool = True) -> FloatArray:
    """Return the distance from each cell to each of F fires, (..., F); Euclidean if `straight`, else in moves."""
    centres = np.array([fire.position for fire in world.fires], dtype=np.int64).reshape(-1, 2)
    across, along = np.abs(x[..., None] - centres[:, 0]), np.abs(y[..., None] - centres[:, 1])
    return np.asarray(np.hypot(across, along) if straight else across + along, dtype=np.float64)


def to_nearest_agent(
    x: IntArray,
    y: IntArray,
    standing_x: IntArray,
    standing_y: IntArray,
    own: IntArray,
    there: BoolArray | None = None,
) -> FloatArray:
    """Return the fewest moves, ignoring walls, from each cell to the nearest other agent, (R, k); NaN without one.

    Args:
        x: columns of the cells, (R, k).
        y: rows of the cells, (R, k).
        standing_x: columns of all agents, (R, N).
        standing_y: rows of all agents, (R, N).
        own: index of the agent that does not count as another one, (R,).
        there: whether each agent is present, (R, N); None if all are.
    """
    rows, agents = standing_x.shape
    if agents < 2:
        return np.full(x.shape, np.nan)
    nearest = np.empty(x.shape)
    size = max(1, _AT_ONCE // (agents * x.shape[1]))
    for start in range(0, rows, size):
        part = slice(start, start + size)
        away = np.abs(x[part, :, None] - standing_x[part, None]) + np.abs(y[part, :, None] - standing_y[part, None])
        nobody = np.iinfo(away.dtype).max
        away[np.arange(len(away)), :, own[part]] = nobody
        if there is not None:
            away[np.broadcast_to(~there[part, None], away.shape)] = nobody
        least = away.min(axis=2)
        nearest[part] = np.where(least == nobody, np.nan, least)
    return nearest


def steps_to(goal: BoolArray, free: BoolArray) -> IntArray:
    """Return the fewest steps from every cell of a grid to the nearest goal, (W, H); -1 where no path leads there.

    Args:
        goal: the goal cells, (W, H).
        free: cells that agents can enter, (W, H); a step leads to one of the four adjacent cells.
    """
    steps, reached, number = np.full(goal.shape, -1), goal & free, 0
    front = reached
    while front.any():
        steps[front] = number
        number += 1
        padded = np.pad(front, 1)
        around = padded[2:, 1:-1] | padded[:-2, 1:-1] | padded[1:-1, 2:] | padded[1:-1, :-2]
        front = around & free & ~reached
        reached = reached | front
    return steps
