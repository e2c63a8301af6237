"""What became of the runs, and how many decisions could not be read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from analysis.plots import style
from analysis.plots.labels import LINE_IN, lines, wrapped
from analysis.prose import percent
from foundry.palette import BASELINE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COMPLETE, FAILED, MISSING = "complete", "failed", "missing"
_COLOURS = {COMPLETE: "#56B4E9", FAILED: "#D55E00", MISSING: "#FFFFFF"}


@dataclass(frozen=True)
class LedgerRow:
    """The runs of one group.

    Attributes:
        label: name of the group.
        complete: runs that came to their end.
        failed: runs that a failure ended.
        missing: runs that were not started or not ended.
        unreadable: share of the decisions that could not be read; NaN without decisions.
        baseline: whether it is there to be compared with only.
    """

    label: str
    complete: int
    failed: int
    missing: int
    unreadable: float
    baseline: bool = False


def draw_ledger(ax: Axes, rows: Sequence[LedgerRow]) -> Axes:
    """Draw a bar of runs for every group, and the share of its decisions that could not be read beside it."""
    places = [-row for row in range(len(rows))]
    start = [0] * len(rows)
    for status, colour in _COLOURS.items():
        counts = [getattr(row, status) for row in rows]
        bars = ax.barh(places, counts, left=start, height=0.6, label=status, color=colour)
        for bar in bars:
            bar.set(edgecolor="#666666", linewidth=0.5)
        start = [sum(pair) for pair in zip(start, counts, strict=True)]
    for place, row in zip(places, rows, strict=True):
        share = "-" if math.isnan(row.unreadable) else percent(row.unreadable)
        ax.text(1.02, place, share, transform=ax.get_yaxis_transform(), va="center", size=7, color=style.DARK)
    ax.text(1.02, 0.65, "unread-\nable", transform=ax.get_yaxis_transform(), va="bottom", size=7, color=style.DARK)
    ax.set_yticks(places, [wrapped(row.label) for row in rows])
    for tick, row in zip(ax.get_yticklabels(), rows, strict=True):
        tick.set_color(BASELINE if row.baseline else style.DARK)
    ax.set_ylim(-len(rows) + 0.4, 0.6)
    ax.locator_params(axis="x", integer=True, nbins=6)
    ax.set_xlabel("Runs")
    ax.legend(loc="lower right", bbox_to_anchor=(1.02, 1), ncols=3, handlelength=1.2, columnspacing=1, borderpad=0.2)
    return ax


def ledger_height(rows: Sequence[LedgerRow]) -> float:
    """Return the height of the picture, inches."""
    return 0.95 + len(rows) * max(0.26, max(lines(row.label) for row in rows) * LINE_IN + 0.04)
