"""Draws the further parts of a 2D world: walls, exits, zones, burning cells and food, and says who is gone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from foundry.palette.fonts import families
from foundry.worlds.grid.space import Cell

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WALL_COLOUR, EXIT_COLOUR, FOOD_COLOUR, BURNING_COLOUR, ZONE_COLOUR = (
    "#444450",
    "#0072B2",
    "#8CC084",
    "#D55E00",
    "#A03050",
)


@dataclass(frozen=True, slots=True)
class Furniture:
    """What a picture shows beside places, fires and agents.

    Attributes:
        ids: of the agents that are there, in the order of the frame's cells.
        walls: cells that nobody can enter.
        exits: name and cells of each exit.
        zones: name and cells of each zone.
        burning: the burning cells.
        food: cells with food, and how full each is, 0 to 1.
        gone: exits and causes of death, and how many went by each so far.
    """

    ids: tuple[int, ...]
    walls: tuple[Cell, ...] = ()
    exits: tuple[tuple[str, tuple[Cell, ...]], ...] = ()
    zones: tuple[tuple[str, tuple[Cell, ...]], ...] = ()
    burning: tuple[Cell, ...] = ()
    food: tuple[tuple[Cell, float], ...] = ()
    gone: tuple[tuple[str, int], ...] = ()


def draw_furniture(axes: Axes, furniture: Furniture) -> None:
    """Draw it below fires and agents; the names of exits stand beside them."""
    _fill(axes, [cell for cell, _ in furniture.food], FOOD_COLOUR, [0.2 + 0.6 * full for _, full in furniture.food])
    for _, cells in furniture.zones:
        _fill(axes, cells, ZONE_COLOUR, 0.2)
    _fill(axes, furniture.walls, WALL_COLOUR, 1.0)
    _fill(axes, furniture.burning, BURNING_COLOUR, 0.55)
    for name, cells in furniture.exits:
        _fill(axes, cells, EXIT_COLOUR, 0.9)
        backing = {"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 1.0}
        place: dict[str, Any] = {"textcoords": "offset points", "ha": "center", "zorder": 7, "bbox": backing}
        axes.annotate(name, cells[0], (0, 9), fontsize=9, fontfamily=families(), color=EXIT_COLOUR, **place)
    if furniture.gone:
        text = ", ".join(f"{count} {name}" for name, count in furniture.gone)
        axes.set_title(f"gone: {text}", fontsize=10, loc="right", y=1.0, color="#333344")


def _fill(axes: Axes, cells: Sequence[Cell], colour: str, alpha: float | Sequence[float]) -> None:
    """Fill cells in a colour, with one transparency or one for each cell."""
    from matplotlib.collections import PolyCollection

    if not cells:
        return
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    squares = np.array(cells, dtype=float).reshape(-1, 1, 2) + corners
    axes.add_collection(PolyCollection(squares, facecolor=colour, alpha=alpha, linewidth=0, zorder=1.5))
