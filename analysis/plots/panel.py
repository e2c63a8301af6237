"""Draws the values of one measure for all groups: a dot per seed, the mean and its interval."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from analysis.arrays import FloatArray
from analysis.plots import style
from analysis.plots.labels import LINE_IN, lines, title_height, title_width, wrapped
from foundry.palette import BASELINE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ROUNDING = 1e-9
"""Difference below which values count as equal."""
_SPREAD = 0.28
_PATTERN = 5
"""Number of different positions of dots across an axis, so that dots of equal values do not hide each other."""


@dataclass(frozen=True)
class Scale:
    """The scale of a measure.

    Attributes:
        low: least possible value.
        high: greatest possible value.
        null: value by chance alone; NaN if unknown.
        best: value of the best scripted policy; NaN if unknown.
    """

    low: float = -math.inf
    high: float = math.inf
    null: float = math.nan
    best: float = math.nan

    @property
    def marks(self) -> list[float]:
        """The values `null` and `best` of the scale, without NaN."""
        return [value for value in (self.null, self.best) if not math.isnan(value)]


ANY = Scale()
"""The scale of an unknown measure."""


@dataclass(frozen=True)
class GroupValues:
    """The values of one measure in one group.

    Attributes:
        values: one value per seed (n,); NaN where undefined.
        index: index among all groups, which selects the colour.
        baseline: whether the group is only a baseline.
    """

    label: str
    values: FloatArray
    mean: float
    low: float
    high: float
    index: int = 0
    seeds: tuple[int, ...] = ()
    baseline: bool = False

    @property
    def colour(self) -> str:
        """Colour of the group."""
        return style.colour(self.index, baseline=self.baseline)

    @property
    def n(self) -> int:
        """Number of seeds with a value."""
        return int((~np.isnan(self.values)).sum())


def draw_panel(ax: Axes, groups: Sequence[GroupValues], title: str, scale: Scale = ANY) -> Axes:
    """Draw the groups below each other, the first on top, each with its number of seeds.

    A dashed line marks the value by chance, and a dotted line the best policy's value.
    """
    for value, dashes in ((scale.null, "--"), (scale.best, ":")):
        if not math.isnan(value):
            ax.axvline(value, color=style.DARK, linestyle=dashes, linewidth=0.9, zorder=1)
    for row, group in enumerate(groups):
        _draw_group(ax, group, -row)
    ax.set_ylim(-len(groups) + 0.45, 0.55)
    shown = (value for group in groups for value in (*group.values, group.mean, group.low, group.high))
    set_limits(ax, (*shown, *scale.marks), scale)
    _label_rows(ax, groups, title)
    return ax


def _label_rows(ax: Axes, groups: Sequence[GroupValues], title: str) -> None:
    ax.set_title(wrapped(title, title_width(group.label for group in groups)))
    ax.set_yticks([-row for row in range(len(groups))], [wrapped(group.label) for group in groups])
    for tick, group in zip(ax.get_yticklabels(), groups, strict=True):
        tick.set_color(BASELINE if group.baseline else style.DARK)
    for row, group in enumerate(groups):
        ax.text(1.02, -row, f"n={group.n}", transform=ax.get_yaxis_transform(), va="center", color=style.DARK, size=7)


def panel_height(labels: Sequence[str], title: str = "") -> float:
    """Return the height of a panel of groups with the given labels, inches."""
    most = max(lines(label) for label in labels)
    return 0.6 + title_height(title, title_width(labels)) + len(labels) * max(0.21, most * LINE_IN + 0.04)


def _draw_group(ax: Axes, group: GroupValues, row: int) -> None:
    if math.isnan(group.mean):
        write_undefined(ax, row)
        return
    colour = group.colour
    ax.scatter(group.values, row + jitter(len(group.values)), s=9, color=colour, alpha=0.45, linewidths=0)
    if not math.isnan(group.low):
        ax.plot([group.low, group.high], [row, row], color=colour, linewidth=1.6, solid_capstyle="butt")
    shape = style.marker(group.index, baseline=group.baseline)
    ax.plot([group.mean], [row], marker=shape, markersize=6, color=colour, markeredgecolor="white", markeredgewidth=0.5)


def write_undefined(ax: Axes, row: float) -> None:
    """Write the word "undefined" in a row of a plot."""
    ax.text(0.02, row, "undefined", transform=ax.get_yaxis_transform(), va="center", color="#888888", size=7)


def jitter(count: int) -> FloatArray:
    """Return fixed offsets (count,) that separate the dots of successive seeds."""
    return ((np.arange(count) * 2 % _PATTERN) / (_PATTERN - 1) * 2 - 1) * _SPREAD


def set_limits(ax: Axes, shown: Iterable[float], scale: Scale = ANY, *, upwards: bool = False) -> None:
    """Set the limits and the ticks of an axis; ticks are only at possible values.

    Args:
        ax: target axes.
        shown: values that must be visible.
        scale: limits of all values.
        upwards: whether values increase upwards instead of to the right.
    """
    axis, limit = (ax.yaxis, ax.set_ylim) if upwards else (ax.xaxis, ax.set_xlim)
    finite = [float(value) for value in shown if math.isfinite(value)]
    if not finite:
        limit(0, 1)
        axis.set_ticks([])
        return
    low, high = min(finite), max(finite)
    if high - low <= _ROUNDING:
        room = 0.05 * max(1.0, abs(high))
        limit(max(low - room, scale.low) - 0.06 * room, min(high + room, scale.high) + 0.06 * room)
        axis.set_ticks([low], [f"{low:.3g}"])
        return
    margin = 0.06 * (high - low)
    limit(low - margin, high + margin)
    ax.locator_params(axis="y" if upwards else "x", nbins=4)
    first, last = max(low - margin, scale.low), min(high + margin, scale.high)
    axis.set_ticks([tick for tick in axis.get_ticklocs() if first <= tick <= last])
