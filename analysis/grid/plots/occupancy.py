"""Draws maps of the agents' positions, and their paths."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.image import AxesImage

from analysis.arrays import FloatArray
from analysis.figures.shown import ShownGroup
from analysis.grid.grid_run import GridRun, GridSettings
from analysis.plots import style
from analysis.plots.labels import wrapped
from foundry.palette import BASELINE

COLOURS = "Blues"
MAP_TITLE_WIDTH = 17


@dataclass(frozen=True)
class OccupancyMap:
    """How much of the time the agents of a group spend in each cell.

    Attributes:
        share: share of all agent-steps, by row and column of the grid, lowest row first, (W, W).
    """

    shown: ShownGroup
    world: GridSettings
    share: FloatArray


def draw_occupancy(ax: Axes, occupancy: OccupancyMap, most: float) -> AxesImage:
    """Draw a map, darker for frequent cells, and return its image for a colour bar.

    Colours follow the square root of the share, so that small shares stay visible.

    Args:
        ax: where to draw.
        occupancy: the map.
        most: share at the end of the colour scale.
    """
    from matplotlib.colors import PowerNorm

    half = occupancy.world.half_size + 0.5
    image = ax.imshow(
        occupancy.share,
        cmap=COLOURS,
        norm=PowerNorm(0.5, 0, most or 1.0),
        extent=(-half, half, -half, half),
        origin="lower",
        interpolation="nearest",
    )
    draw_world(ax, occupancy.world, style.PLACE)
    _title(ax, occupancy.shown)
    return image


def draw_paths(ax: Axes, shown: ShownGroup, run: GridRun) -> Axes:
    """Draw one line per agent of a group's run, from its start (dot) to its end (ring)."""
    draw_world(ax, run.world, style.PLACE)
    colour = shown.colour
    # One line with gaps keeps the file small.
    gap = np.full((1, run.agents), np.nan)
    x, y = (np.vstack([places, gap]).T.ravel() for places in (run.x, run.y))
    ax.plot(x, y, color=colour, linewidth=0.6, alpha=0.6)
    ax.scatter(run.x[0], run.y[0], s=5, color=colour, linewidths=0, zorder=3)
    ax.scatter(run.x[-1], run.y[-1], s=9, facecolors="white", edgecolors=colour, linewidths=0.7, zorder=3)
    _title(ax, shown)
    return ax


def draw_world(ax: Axes, world: GridSettings, colour: str) -> None:
    """Draw walls, exits, the outlines of places, and fires as crosses with a ring at their radius."""
    from matplotlib.patches import Circle, Rectangle

    for (x, y), (other_x, other_y) in world.walls:
        low = (min(x, other_x) - 0.5, min(y, other_y) - 0.5)
        ax.add_patch(Rectangle(low, abs(other_x - x) + 1, abs(other_y - y) + 1, facecolor=BASELINE, linewidth=0))
    for x, y in (cell for exit_zone in world.exits for cell in exit_zone.cells):
        ax.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor=style.PLACE, linewidth=0))

    for place in world.places:
        corner = (place.low[0] - 0.5, place.low[1] - 0.5)
        size = (place.high[0] - place.low[0] + 1, place.high[1] - place.low[1] + 1)
        ax.add_patch(Rectangle(corner, *size, fill=False, edgecolor=colour, linewidth=0.8))
    for fire in world.fires:
        ring = Circle(fire.position, fire.radius, fill=False, edgecolor=style.FIRE, linewidth=0.7, linestyle="--")
        ax.add_patch(ring)
        ax.plot(*fire.position, marker="x", markersize=4, color=style.FIRE)
    half = world.half_size + 0.5
    ax.set(xlim=(-half, half), ylim=(-half, half), aspect="equal", xticks=[], yticks=[])
    ax.grid(False)
    ax.spines[:].set_visible(True)


def map_titles(labels: Sequence[str]) -> int:
    """Return the number of lines of the longest title among the maps."""
    return max(wrapped(label, MAP_TITLE_WIDTH).count("\n") + 1 for label in labels)


def _title(ax: Axes, shown: ShownGroup) -> None:
    colour = BASELINE if shown.baseline else style.DARK
    ax.set_title(wrapped(shown.label, MAP_TITLE_WIDTH), size=7, color=colour, pad=3)
