"""What was found of one measure, as small as several stand beside one another on one screen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from analysis.plots import style
from analysis.plots.figures import new_figure
from analysis.plots.forest import Pair, draw_pairs
from analysis.plots.labels import LINE_IN, wrapped
from analysis.plots.panel import GroupValues, Scale, draw_groups
from foundry.palette import BASELINE

WIDTH_IN = 3.5
_TITLE_WIDTH = 52
_AROUND_IN = 0.34
"""The scale below the rows and the room above them, inches."""
_GROUP_IN, _PAIR_IN = 0.13, 0.112
_LEAST_IN = 0.5
_TICKS = 3


def glance_figure(
    title: str, groups: Sequence[GroupValues], scale: Scale, pairs: Sequence[Pair], names: Mapping[str, str]
) -> Figure:
    """Return means, and beside them the paired differences, if any; how many seeds, only where some have fewer.

    Args:
        title: what the measure is called.
        groups: its results.
        scale: what they are seen against.
        pairs: the differences.
        names: short names of the groups by their labels, which are told elsewhere.
    """
    title = wrapped(title, _TITLE_WIDTH)
    above = LINE_IN * (title.count("\n") + 1)
    rows = max(len(groups) * _GROUP_IN, len(pairs) * _PAIR_IN, _LEAST_IN)
    figure = new_figure(above + rows + _AROUND_IN, WIDTH_IN)
    figure.suptitle(title, x=0.01, ha="left", size=8)
    panels = figure.subplots(1, 2 if pairs else 1, squeeze=False, width_ratios=[1.3, 1] if pairs else None)[0]
    draw_groups(panels[0], groups, scale)
    _name_rows(panels[0], groups, names)
    if pairs:
        most = max(pair.pairs for pair in pairs)
        texts = [f"{_fewer(pair.pairs, most)} {pair.mark}".strip() for pair in pairs]
        draw_pairs(panels[1], pairs, texts, ticks=_TICKS)
    return figure


def _name_rows(ax: Axes, groups: Sequence[GroupValues], names: Mapping[str, str]) -> None:
    most = max((group.n for group in groups), default=0)
    ax.set_yticks([-row for row in range(len(groups))], [names[group.label] for group in groups])
    for row, (tick, group) in enumerate(zip(ax.get_yticklabels(), groups, strict=True)):
        tick.set_color(BASELINE if group.baseline else style.DARK)
        text = _fewer(group.n, most)
        ax.text(1.02, -row, text, transform=ax.get_yaxis_transform(), va="center", size=7, color=style.DARK)


def _fewer(count: int, most: int) -> str:
    return f"n={count}" if count < most else ""
