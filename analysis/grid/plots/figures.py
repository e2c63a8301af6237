"""Whole figures of 2D worlds: maps beside one another, curves, who warned whom."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from analysis.grid.plots.cascade import CascadeTree, cascade_height, draw_cascade
from analysis.grid.plots.occupancy import GridPaths, OccupancyMap, draw_occupancy, draw_paths, map_titles
from analysis.grid.plots.survival import SurvivalCurve, draw_survival
from analysis.plots import style
from analysis.plots.figures import new_figure, stacked
from analysis.plots.labels import LINE_IN, wrapped

_MAPS_A_ROW = 3


def _map_rows(count: int) -> int:
    return math.ceil(count / _MAPS_A_ROW)


def _maps(labels: Sequence[str], extra: float) -> tuple[Figure, list[Axes]]:
    """Return a figure with a square panel for each label, three in a row."""
    rows, columns = _map_rows(len(labels)), min(len(labels), _MAPS_A_ROW)
    side = 0.95 * style.WIDTH_IN / max(columns, 2)
    figure = new_figure(rows * (side + map_titles(labels) * LINE_IN) + extra)
    panels = list(figure.subplots(rows, columns, squeeze=False).flat)
    for ax in panels[len(labels) :]:
        ax.axis("off")
    return figure, panels[: len(labels)]


def occupancy_figure(maps: Sequence[OccupancyMap]) -> Figure:
    """Return where the agents of each group were, on one scale of colours."""
    figure, panels = _maps([found.label for found in maps], extra=0.45)
    tops = [float(found.share.max()) for found in maps]
    # Baselines may stand still in one cell; a scale that ends there would make all else dark.
    most = max([top for top, found in zip(tops, maps, strict=True) if not found.baseline] or tops)
    for ax, found in zip(panels, maps, strict=True):
        image = draw_occupancy(ax, found, most)
    bar = figure.colorbar(
        image,
        ax=figure.axes,
        orientation="horizontal",
        aspect=40,
        pad=0.02,
        fraction=0.06,
        extend="max" if max(tops) > most else "neither",
    )
    bar.locator = MaxNLocator(4)
    bar.set_label("Share of agent-steps in the cell (scaled by square root)")
    bar.outline.set_linewidth(0.4)
    return figure


def paths_figure(paths: Sequence[GridPaths]) -> Figure:
    """Return the ways of the agents in one run of each group."""
    figure, panels = _maps([found.label for found in paths], extra=0.05)
    for ax, found in zip(panels, paths, strict=True):
        draw_paths(ax, found)
    return figure


def survival_figure(curves: Sequence[SurvivalCurve], label: str = "Not yet warned (share)") -> Figure:
    """Return the share of agents that is not warned yet, or what else `label` says, by group."""
    below = sum(wrapped(f"{curve.label} (n={curve.runs})", 40).count("\n") + 1 for curve in curves)
    figure = new_figure(2.2 + 0.15 * below)
    draw_survival(figure.add_subplot(), curves, label)
    return figure


def cascade_figure(trees: Sequence[CascadeTree]) -> Figure:
    """Return who warned whom in one run of each group."""
    figure, panels = stacked([cascade_height(tree) for tree in trees])
    for ax, tree in zip(panels, trees, strict=True):
        draw_cascade(ax, tree)
    panels[-1].set_xlabel("Step")
    figure.supylabel("Agent", size=7.5)
    return figure
