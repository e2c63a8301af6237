"""Draws agents' decisions by round: group means as curves, and single agents as rows of colours (lanes)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from analysis.arrays import FloatArray
from analysis.plots import style
from analysis.plots.figures import new_figure, stacked
from analysis.plots.labels import LINE_IN, wrapped
from analysis.plots.panel import ANY, Scale, set_limits
from foundry.palette import label_colour

_KEY_WIDTH = 40
NUMBERS = "Blues"


@dataclass(frozen=True)
class Curve:
    """A group's mean by round.

    Attributes:
        mean: mean over runs, (T,).
        index: index among all groups, which selects the colour.
        at: positions on the axis, (T,); None means the rounds 1 to T.
    """

    label: str
    mean: FloatArray
    low: FloatArray
    high: FloatArray
    runs: int
    index: int = 0
    baseline: bool = False
    at: FloatArray | None = None


@dataclass(frozen=True)
class Lanes:
    """The decisions of the agents of one run.

    Attributes:
        values: decided numbers, or indices of the decided labels, (N, T); NaN without a decision.
        labels: the labels; empty if numbers are decided.
    """

    label: str
    run: str
    values: FloatArray
    labels: tuple[str, ...]


def curves_figure(panels: Sequence[tuple[str, Sequence[Curve]]], scale: Scale = ANY, across: str = "Round") -> Figure:
    """Return a figure with a panel of curves for each title; the names of groups are below the last panel."""
    key = sum(wrapped(_named(curve), _KEY_WIDTH).count("\n") + 1 for curve in panels[-1][1])
    figure, axes = stacked([1.6] * (len(panels) - 1) + [1.8 + LINE_IN * 1.2 * key])
    for ax, (title, curves) in zip(axes, panels, strict=True):
        for curve in curves:
            _draw_curve(ax, curve)
        ax.set_title(title)
        ax.grid(True, axis="both")
        _count_rounds(ax)
        shown = (value for curve in curves for part in (curve.mean, curve.low, curve.high) for value in part)
        set_limits(ax, shown, scale, upwards=True)
    axes[-1].set_xlabel(across)
    axes[-1].legend(loc="upper left", bbox_to_anchor=(-0.02, -0.3), borderaxespad=0, handlelength=2.2)
    return figure


def _draw_curve(ax: Axes, curve: Curve) -> None:
    rounds = np.arange(1, len(curve.mean) + 1) if curve.at is None else curve.at
    look = style.line(curve.index, baseline=curve.baseline)
    ax.plot(rounds, curve.mean, linewidth=1.2, label=wrapped(_named(curve), _KEY_WIDTH), **look)
    ax.fill_between(rounds, curve.low, curve.high, color=look["color"], alpha=0.15, linewidth=0)


def _named(curve: Curve) -> str:
    return f"{curve.label} (n={curve.runs})"


def lanes_figure(lanes: Sequence[Lanes]) -> Figure:
    """Return a figure with a panel of lanes for each run; a key to the colours is below."""
    labels = lanes[0].labels if lanes else ()
    rows = -(-len(labels) // 3)
    heights = [0.5 + min(0.09 * lane.values.shape[0] + 0.2, 2.4) for lane in lanes]
    figure = new_figure(sum(heights) + 0.45 + 0.15 * rows)
    axes = figure.subplots(max(len(lanes), 1), 1, squeeze=False, height_ratios=heights or [1])[:, 0]
    most = max((float(np.nanmax(lane.values, initial=0.0)) for lane in lanes), default=1.0)
    for ax, lane in zip(axes, lanes, strict=False):
        image = _draw_lanes(ax, lane, most)
    axes[-1].set_xlabel("Round")
    if labels:
        patches = [Patch(color=label_colour(place), label=label) for place, label in enumerate(labels)]
        figure.legend(handles=patches, loc="outside lower center", ncols=3)
    elif lanes:
        figure.colorbar(image, ax=list(axes), orientation="horizontal", aspect=40, pad=0.02)
    return figure


def _draw_lanes(ax: Axes, lane: Lanes, most: float) -> Any:
    agents, rounds = lane.values.shape
    colours: Any = (
        ListedColormap([label_colour(place) for place in range(len(lane.labels))]) if lane.labels else NUMBERS
    )
    top = max(len(lane.labels) - 0.5, 0.5) if lane.labels else most or 1.0
    image = ax.imshow(
        np.ma.masked_invalid(lane.values),
        cmap=colours,
        vmin=-0.5 if lane.labels else min(0.0, float(np.nanmin(lane.values, initial=0.0))),
        vmax=top,
        aspect="auto",
        interpolation="nearest",
        extent=(0.5, rounds + 0.5, agents - 0.5, -0.5),
    )
    ax.set_title(wrapped(lane.label, _KEY_WIDTH))
    ax.set_ylabel("Agent")
    ax.grid(False)
    _count_rounds(ax)
    return image


def _count_rounds(ax: Axes) -> None:
    ax.xaxis.set_major_locator(MaxNLocator(6, integer=True))
