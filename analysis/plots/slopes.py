"""One measure, a line a seed: whether all seeds agree about a difference between groups."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from analysis.plots import style
from analysis.plots.panel import ANY, GroupValues, Scale, draw_marks, label_rows, set_limits, write_undefined

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_slopes(ax: Axes, groups: Sequence[GroupValues], title: str, scale: Scale = ANY) -> Axes:
    """Draw a line for every seed through its values in the groups, which stand below one another.

    A line is broken where a group has no value for the seed; baselines are apart from it.

    Args:
        ax: where to.
        groups: results of one measure, baselines last.
        title: what the measure is called.
        scale: what the values are seen against.
    """
    draw_marks(ax, scale)
    found = [dict(zip(group.seeds, group.values.tolist(), strict=True)) for group in groups]
    rows = [-row for row in range(len(groups))]
    linked = [one for one, group in zip(found, groups, strict=True) if not group.baseline]
    seeds = sorted({seed for one in linked for seed in one})
    # One line with gaps, which takes little room in a file.
    across = [value for seed in seeds for value in (*(one.get(seed, math.nan) for one in linked), math.nan)]
    ax.plot(across, [*rows[: len(linked)], math.nan] * len(seeds), color=style.FAINT, linewidth=0.7, zorder=1.5)
    for row, group in zip(rows, groups, strict=True):
        ax.scatter(group.values, [row] * len(group.values), s=8, color=group.colour, linewidths=0, zorder=2)
        if math.isnan(group.mean):
            write_undefined(ax, row)
    means = [group.mean for group in groups]
    ax.plot(means[: len(linked)], rows[: len(linked)], color="black", linewidth=1.2, zorder=3)
    ax.plot(means, rows, color="black", linestyle="", marker="|", markersize=6, zorder=3)
    label_rows(ax, groups, title)
    ax.set_ylim(-len(groups) + 0.45, 0.55)
    set_limits(ax, (*(value for one in found for value in one.values()), *scale.marks), scale)
    return ax
