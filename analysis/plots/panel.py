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

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SPREAD = 0.28
_PATTERN = 5
"""Rows over which the dots of successive seeds are spread, so that equal values stay apart."""


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


def draw_panel(ax: Axes, groups: Sequence[GroupValues], title: str) -> Axes:
    """Draw the groups below one another, the first on top, each with its number of seeds.

    Args:
        ax: where to.
        groups: results of one measure.
        title: what the measure is called.
    """
    for row, group in enumerate(groups):
        _draw_group(ax, group, -row)
    label_rows(ax, groups, title)
    set_limits(ax, (value for group in groups for value in (*group.values, group.mean, group.low, group.high)))
    return ax


def label_rows(ax: Axes, groups: Sequence[GroupValues], title: str) -> None:
    """Write the title, the names of the groups, and how many seeds each has."""
    ax.set_title(wrapped(title, title_width(group.label for group in groups)))
    ax.set_yticks([-row for row in range(len(groups))], [wrapped(group.label) for group in groups])
    for tick, group in zip(ax.get_yticklabels(), groups, strict=True):
        tick.set_color(style.BASELINE if group.baseline else style.DARK)
    for row, group in enumerate(groups):
        ax.text(1.02, -row, f"n={group.n}", transform=ax.get_yaxis_transform(), va="center", color=style.DARK, size=7)
    ax.set_ylim(-len(groups) + 0.45, 0.55)


def panel_height(labels: Sequence[str], title: str = "") -> float:
    """Return the height of a panel of groups with these labels, inches."""
    most = max(lines(label) for label in labels)
    return 0.6 + title_height(title, title_width(labels)) + len(labels) * max(0.3, most * LINE_IN + 0.04)


def _draw_group(ax: Axes, group: GroupValues, row: int) -> None:
    if math.isnan(group.mean):
        write_undefined(ax, row)
        return
    colour = group.colour
    ax.scatter(group.values, row + jitter(len(group.values)), s=9, color=colour, alpha=0.45, linewidths=0)
    if not math.isnan(group.low):
        ax.plot([group.low, group.high], [row, row], color=colour, linewidth=1.6, solid_capstyle="butt")
    shape = style.marker(group.index, baseline=group.baseline)
    ax.plot([group.mean], [row], marker=shape, markersize=4.5, color=colour, markeredgecolor="white")


def write_undefined(ax: Axes, row: float) -> None:
    """Say that there is no value in a row."""
    ax.text(0.02, row, "undefined", transform=ax.get_yaxis_transform(), va="center", color="#888888", size=7)


def jitter(count: int) -> FloatArray:
    """Return offsets that keep the dots of successive seeds apart, always the same (count,)."""
    return ((np.arange(count) * 2 % _PATTERN) / (_PATTERN - 1) * 2 - 1) * _SPREAD


def set_limits(ax: Axes, shown: Iterable[float]) -> None:
    """Set limits around the data; a plot of equal values gets some room, too."""
    finite = [float(value) for value in shown if math.isfinite(value)]
    if not finite:
        ax.set_xlim(0, 1)
        ax.set_xticks([])
        return
    low, high = min(finite), max(finite)
    margin = 0.06 * (high - low) if high - low > 1e-9 else 0.05 * max(1.0, abs(high))
    ax.set_xlim(low - margin, high + margin)
    ax.locator_params(axis="x", nbins=5)
