"""One measure, all groups: a dot per seed, the mean and its interval."""

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
"""Up to here values are one."""
_SPREAD = 0.28
_PATTERN = 5
"""Rows over which the dots of successive seeds are spread, so that equal values stay apart."""


@dataclass(frozen=True)
class Scale:
    """What the values of a measure are seen against; NaN is what is not known.

    Attributes:
        low: least possible value.
        high: greatest possible value.
        null: what chance alone gives.
        best: what the best scripted policy reaches.
    """

    low: float = -math.inf
    high: float = math.inf
    null: float = math.nan
    best: float = math.nan

    @property
    def marks(self) -> list[float]:
        """The values that are marked."""
        return [value for value in (self.null, self.best) if not math.isnan(value)]


ANY = Scale()
"""Of a measure of which nothing is known."""


@dataclass(frozen=True)
class GroupValues:
    """The results of one group.

    Attributes:
        label: name of the group.
        values: one value per seed (n,); NaN where undefined.
        mean: their mean.
        low: lower end of its interval, or NaN.
        high: upper end.
        index: place among all groups, which decides the colour.
        seeds: the seed of each value.
        baseline: whether it is there to be compared with only.
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
        """Its colour."""
        return style.colour(self.index, baseline=self.baseline)

    @property
    def n(self) -> int:
        """Number of seeds with a value."""
        return int((~np.isnan(self.values)).sum())


def draw_panel(ax: Axes, groups: Sequence[GroupValues], title: str, scale: Scale = ANY) -> Axes:
    """Draw the groups below one another, the first on top, each with its number of seeds.

    Args:
        ax: where to.
        groups: results of one measure.
        title: what the measure is called.
        scale: what the values are seen against.
    """
    draw_groups(ax, groups, scale)
    label_rows(ax, groups, title)
    return ax


def draw_groups(ax: Axes, groups: Sequence[GroupValues], scale: Scale) -> None:
    """Draw the groups below one another, and what their values are seen against, without any word."""
    draw_marks(ax, scale)
    for row, group in enumerate(groups):
        _draw_group(ax, group, -row)
    ax.set_ylim(-len(groups) + 0.45, 0.55)
    shown = (value for group in groups for value in (*group.values, group.mean, group.low, group.high))
    set_limits(ax, (*shown, *scale.marks), scale)


def draw_marks(ax: Axes, scale: Scale) -> None:
    """Draw what chance alone gives as a broken line, and the best as a dotted one."""
    for value, dashes in ((scale.null, "--"), (scale.best, ":")):
        if not math.isnan(value):
            ax.axvline(value, color=style.DARK, linestyle=dashes, linewidth=0.9, zorder=1)


def label_rows(ax: Axes, groups: Sequence[GroupValues], title: str) -> None:
    """Write the title, the names of the groups, and how many seeds each has."""
    ax.set_title(wrapped(title, title_width(group.label for group in groups)))
    ax.set_yticks([-row for row in range(len(groups))], [wrapped(group.label) for group in groups])
    for tick, group in zip(ax.get_yticklabels(), groups, strict=True):
        tick.set_color(BASELINE if group.baseline else style.DARK)
    for row, group in enumerate(groups):
        ax.text(1.02, -row, f"n={group.n}", transform=ax.get_yaxis_transform(), va="center", color=style.DARK, size=7)


def panel_height(labels: Sequence[str], title: str = "") -> float:
    """Return the height of a panel of groups with these labels, inches."""
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
    """Say that there is no value in a row."""
    ax.text(0.02, row, "undefined", transform=ax.get_yaxis_transform(), va="center", color="#888888", size=7)


def jitter(count: int) -> FloatArray:
    """Return offsets that keep the dots of successive seeds apart, always the same (count,)."""
    return ((np.arange(count) * 2 % _PATTERN) / (_PATTERN - 1) * 2 - 1) * _SPREAD


def set_limits(ax: Axes, shown: Iterable[float], scale: Scale = ANY, *, ticks: int = 4, upwards: bool = False) -> None:
    """Set limits around the data; no tick where no value can be, and of equal values one alone, with room around it.

    Args:
        ax: where to.
        shown: what has to be seen.
        scale: between which values all lie.
        ticks: how many intervals between ticks there are at most.
        upwards: whether values go up, and not to the right.
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
    ax.locator_params(axis="y" if upwards else "x", nbins=ticks)
    first, last = max(low - margin, scale.low), min(high + margin, scale.high)
    axis.set_ticks([tick for tick in axis.get_ticklocs() if first <= tick <= last])
