"""How long it takes until agents are first warned, or gone: the share that is not yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from analysis.arrays import FloatArray
from analysis.plots import style
from analysis.plots.labels import wrapped

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class SurvivalCurve:
    """The agents of a group that are not warned yet, or still there.

    Attributes:
        label: name of the group.
        remaining: mean over runs of their share, if censored by Kaplan and Meier, at steps 0..T, (T + 1,).
        low: lower end of its interval over runs, (T + 1,); NaN where there is none.
        high: upper end.
        runs: how many runs have a curve.
        index: place among all groups, which decides the colour.
        baseline: whether the group is there to be compared with only.
    """

    label: str
    remaining: FloatArray
    low: FloatArray
    high: FloatArray
    runs: int
    index: int = 0
    baseline: bool = False


def draw_survival(ax: Axes, curves: Sequence[SurvivalCurve], label: str) -> Axes:
    """Draw a falling line a group, with its band over runs; `label` says what is left."""
    for curve in curves:
        steps = np.arange(len(curve.remaining))
        look = style.line(curve.index, baseline=curve.baseline)
        name = wrapped(f"{curve.label} (n={curve.runs})", 40)
        ax.step(steps, curve.remaining, where="post", linewidth=1.0 if curve.baseline else 1.4, label=name, **look)
        ax.fill_between(steps, curve.low, curve.high, step="post", color=look["color"], alpha=0.15, linewidth=0)
    ax.set(xlabel="Step", ylabel=label, ylim=(-0.03, 1.03))
    ax.grid(True, axis="both")
    ax.legend(loc="upper left", bbox_to_anchor=(-0.02, -0.22), borderaxespad=0, handlelength=2.2)
    return ax
