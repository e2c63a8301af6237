"""One measure, all groups: a dot per seed, the mean and its interval."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from analysis.plots import style
from analysis.run import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LABEL_WIDTH = 20
_LABEL_LETTER_IN, _TITLE_LETTER_IN = 0.068, 0.075
_MARGINS_IN = 0.2
_LINE_IN = 0.13
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
    """

    label: str
    values: FloatArray
    mean: float
    low: float
    high: float
    index: int = 0


def draw_panel(ax: Axes, groups: Sequence[GroupValues], title: str) -> Axes:
    """Draw the groups below one another, the first on top.

    Args:
        ax: where to.
        groups: results of one measure.
        title: what the measure is called.
    """
    for row, group in enumerate(groups):
        _draw_group(ax, group, -row, style.colour(group.index))
    ax.set_title(wrapped(title, title_width([group.label for group in groups])))
    ax.set_yticks([-row for row in range(len(groups))], [wrapped(group.label) for group in groups])
    ax.set_ylim(-len(groups) + 0.45, 0.55)
    _set_limits(ax, groups)
    return ax


def panel_height(labels: Sequence[str], title: str = "") -> float:
    """Return the height of a panel of groups with these labels, inches."""
    lines = max(wrapped(label).count("\n") + 1 for label in labels)
    above = wrapped(title, title_width(labels)).count("\n") * _LINE_IN
    return 0.6 + above + len(labels) * max(0.3, lines * _LINE_IN + 0.04)


def title_width(labels: Sequence[str]) -> int:
    """Return how many characters of a title fit above a panel, to the right of these labels."""
    longest = max(len(line) for label in labels for line in wrapped(label).split("\n"))
    return int((style.WIDTH_IN - _MARGINS_IN - longest * _LABEL_LETTER_IN) / _TITLE_LETTER_IN)


def _draw_group(ax: Axes, group: GroupValues, row: int, colour: str) -> None:
    if math.isnan(group.mean):
        ax.text(0.02, row, "undefined", transform=ax.get_yaxis_transform(), va="center", color="#888888")
        return
    ax.scatter(group.values, row + jitter(len(group.values)), s=9, color=colour, alpha=0.45, linewidths=0)
    if not math.isnan(group.low):
        ax.plot([group.low, group.high], [row, row], color=colour, linewidth=1.6, solid_capstyle="butt")
    ax.plot([group.mean], [row], marker="D", markersize=4.5, color=colour, markeredgecolor="white")


def jitter(count: int) -> FloatArray:
    """Return offsets that keep the dots of successive seeds apart, always the same (count,)."""
    return ((np.arange(count) * 2 % _PATTERN) / (_PATTERN - 1) * 2 - 1) * _SPREAD


def _set_limits(ax: Axes, groups: Sequence[GroupValues]) -> None:
    """Set limits around the data; a plot of equal values gets some room, too."""
    shown = [value for group in groups for value in (*group.values, group.mean, group.low, group.high)]
    finite = [float(value) for value in shown if not math.isnan(value)]
    if not finite:
        ax.set_xlim(0, 1)
        ax.set_xticks([])
        return
    low, high = min(finite), max(finite)
    margin = 0.06 * (high - low) if high - low > 1e-9 else 0.05 * max(1.0, abs(high))
    ax.set_xlim(low - margin, high + margin)
    ax.locator_params(axis="x", nbins=6)


def wrapped(label: str, width: int = _LABEL_WIDTH) -> str:
    """Return a label in lines of at most `width` characters, broken behind blanks and `/ : - _ .` where it can."""
    lines = [""]
    for piece in re.findall(r"[^\s/:_.-]*[\s/:_.-]*", label):
        for start in range(0, len(piece), width):
            part = piece[start : start + width]
            if len((lines[-1] + part).rstrip()) > width:
                lines.append("")
            lines[-1] += part
    return "\n".join(line.strip() for line in lines if line.strip())
