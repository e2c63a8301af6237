"""How every two models agree, and each with itself, in one square: one figure above the diagonal, another below it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from analysis.plots import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

UPPER, LOWER = "Blues", "Oranges"
"""The colours above and on the diagonal, and below it."""
_MOST_INTERVALS = 5
"""Models up to which a cell has room for its interval."""
_DARK = 0.6


@dataclass(frozen=True)
class Estimated:
    """A mean with the ends of its interval; NaN where unknown."""

    mean: float
    low: float
    high: float


def draw_matrix(ax: Axes, names: Sequence[str], cells: Mapping[tuple[int, int], Estimated]) -> Axes:
    """Draw the cells that there are, each with its number, from 0 (white) to 1.

    Args:
        ax: where to.
        names: of the rows, from the top, and of the columns.
        cells: by row and column.
    """
    size = len(names)
    means = np.full((size, size), np.nan)
    for place, one in cells.items():
        means[place] = one.mean
    below = np.tri(size, k=-1, dtype=bool)
    for colours, hidden in ((UPPER, below), (LOWER, ~below)):
        ax.imshow(np.ma.masked_where(hidden | np.isnan(means), means), cmap=colours, vmin=0, vmax=1, aspect="auto")
    for (row, column), one in cells.items():
        colour = "white" if one.mean > _DARK else style.DARK
        ax.text(column, row, _text(one, size), ha="center", va="center", size=6.5, color=colour)
    ax.set_xticks(range(size), list(names))
    ax.set_yticks(range(size), list(names))
    ax.tick_params(length=0)
    ax.grid(visible=False)
    return ax


def _text(one: Estimated, size: int) -> str:
    if math.isnan(one.mean):
        return "-"
    if size > _MOST_INTERVALS or math.isnan(one.low):
        return _number(one.mean)
    return f"{_number(one.mean)}\n[{_number(one.low)}, {_number(one.high)}]"


def _number(value: float) -> str:
    return f"{round(value, 2) + 0.0:.2f}"
