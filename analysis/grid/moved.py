"""A null for worlds in which the seed draws the positions of fires and places.

The positions are drawn again many times, and each time the agents' recorded paths are measured against the new
positions. Agents that ignore fires and places would take the same paths whatever positions are drawn. For agents that
ignore fires and places, the actual positions are just one more draw. If agents ignore fires and places, a measure minus
its mean over the other draws is therefore 0 on average, whatever habits the agents have.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from analysis.arrays import BoolArray, FloatArray, IntArray
from analysis.grid.grid_run import GridRun, GridSettings
from foundry import seeding
from foundry.seeding.positions import PositionLaw

DRAWS = 100
"""Number of new draws of the positions for each run."""


def beyond_moved(run: GridRun, statistic: Callable[[GridRun], FloatArray]) -> FloatArray:
    """Return each statistic of a run minus the statistic's mean over copies of the run with other positions.

    Args:
        run: a run of a world that draws positions.
        statistic: function of a run that returns numbers (k,), NaN where undefined; copies with NaN are left out of the
            mean.
    """
    draws = np.stack([statistic(moved) for moved in _moved(run)])
    defined = ~np.isnan(draws)
    counts = defined.sum(axis=0)
    sums = np.where(defined, draws, 0.0).sum(axis=0)
    means = np.divide(sums, counts, out=np.full(counts.shape, np.nan), where=counts > 0)
    return np.asarray(statistic(run) - means)


def in_sight(run: GridRun) -> GridRun:
    """Return the run with the fires that its agents would perceive if the observations mentioned fires."""
    return run if run.world.tell_fires else replace(run, fires=_reached(run.world, run.x[:-1], run.y[:-1]))


def _moved(run: GridRun) -> Iterator[GridRun]:
    """Yield DRAWS copies of the run with places and fires at other positions, the same at every call."""
    world, starts = run.world, np.column_stack([run.x[0], run.y[0]])
    extents = np.array([place.extent for place in world.places], dtype=np.int64).reshape(-1, 2)
    law = PositionLaw(world.half_size, extents, len(world.fires), starts)
    rng = seeding.stream(0, f"moved positions of {run.id}")
    for _ in range(DRAWS):
        there = law.draw(rng).of(world)
        fires = _reached(there, run.x[:-1], run.y[:-1])
        yield replace(run, world=there, place=there.areas(run.x, run.y), fires=fires)


def _reached(world: GridSettings, x: IntArray, y: IntArray) -> BoolArray:
    """Return whether each agent is within the radius of each burning fire, (T, N, F); x and y have shape (T, N)."""
    centres = np.array([fire.position for fire in world.fires], dtype=np.int64).reshape(-1, 2)
    squares = (x[..., None] - centres[:, 0]) ** 2 + (y[..., None] - centres[:, 1]) ** 2
    radii = np.array([fire.radius for fire in world.fires], dtype=np.float64)
    starts = np.array([fire.start for fire in world.fires], dtype=np.int64)
    burning = np.less_equal(starts, np.arange(1, len(x) + 1)[:, None, None])
    # The world compares the root of a whole number; hypot may differ in its last digit.
    return np.asarray((np.sqrt(squares) <= radii) & burning)
