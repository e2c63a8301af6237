"""Draws the paired differences in one measure, each with its interval."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from analysis.plots import style
from analysis.plots.labels import title_height, title_width, wrapped
from analysis.plots.panel import set_limits, write_undefined
from foundry.palette import BASELINE, COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ROW_IN = 0.19


@dataclass(frozen=True)
class Pair:
    """The paired difference of two groups in one measure.

    Attributes:
        label: names of the two groups, first minus second.
        difference: mean of the paired differences; NaN without pairs.
        equivalent: whether the two groups are equal within the declared margin.
        tested: whether the pair is in the family of tests.
    """

    label: str
    difference: float
    low: float
    high: float
    pairs: int
    significant: bool
    equivalent: bool
    tested: bool

    @property
    def mark(self) -> str:
        """The mark of a pair: a star for a significant difference, a tilde for equality."""
        return ("*" if self.significant else "") + ("~" if self.equivalent else "")


def draw_forest(ax: Axes, pairs: Sequence[Pair], title: str) -> Axes:
    """Draw the pairs below each other; a significant difference has a filled mark and a star."""
    shown = [pair for pair in pairs if not math.isnan(pair.difference)]
    if shown:
        ax.axvline(0, color="#999999", linewidth=0.8, zorder=1)
    for row, pair in enumerate(pairs):
        text = f"n={pair.pairs} {pair.mark}".strip()
        ax.text(1.02, -row, text, transform=ax.get_yaxis_transform(), va="center", size=7, color=style.DARK)
        _draw_pair(ax, pair, -row)
    ax.set_yticks([-row for row in range(len(pairs))], [pair.label for pair in pairs])
    ax.set_ylim(-len(pairs) + 0.4, 0.6)
    values = (value for pair in shown for value in (0.0, pair.difference, pair.low, pair.high))
    set_limits(ax, values)
    ax.set_title(wrapped(title, title_width(pair.label for pair in pairs)))
    return ax


def forest_height(pairs: Sequence[Pair], title: str) -> float:
    """Return the height of a panel of the given pairs, inches."""
    return 0.6 + title_height(title, title_width(pair.label for pair in pairs)) + len(pairs) * _ROW_IN


def _draw_pair(ax: Axes, pair: Pair, row: int) -> None:
    if math.isnan(pair.difference):
        write_undefined(ax, row)
        return
    colour = COLOURS[0] if pair.tested else BASELINE
    if not math.isnan(pair.low):
        ax.plot([pair.low, pair.high], [row, row], color=colour, linewidth=1.4, solid_capstyle="butt")
    face = colour if pair.significant else "white"
    ax.plot([pair.difference], [row], marker="o", markersize=4, color=colour, markerfacecolor=face)
