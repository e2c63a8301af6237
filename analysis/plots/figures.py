"""Whole figures: panels above or beside one another, with their legends and colour bars."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import MaxNLocator

from analysis.plots import style
from analysis.plots.cascade import CascadeTree, cascade_height, draw_cascade
from analysis.plots.fingerprints import FingerprintMap, draw_dendrogram, draw_fingerprint
from analysis.plots.forest import Pair, draw_forest, forest_height
from analysis.plots.labels import LINE_IN, keys, lines, wrapped
from analysis.plots.ledger import LedgerRow, draw_ledger, ledger_height
from analysis.plots.occupancy import GridPaths, OccupancyMap, draw_occupancy, draw_paths, map_titles
from analysis.plots.panel import GroupValues, draw_panel, panel_height
from analysis.plots.slopes import draw_slopes
from analysis.plots.survival import SurvivalCurve, draw_survival
from analysis.plots.topdown import TopDown, draw_topdown

_KEY_WIDTH = 46
_MAPS_A_ROW = 3
_HEAT_IN = 1.6
"""Width that is left for a heatmap beside the names of its rows."""


def new_figure(height: float) -> Figure:
    """Return an empty figure one column wide; height in inches."""
    return Figure(figsize=(style.WIDTH_IN, height), dpi=style.DPI, layout="constrained", facecolor="white")


def stacked(heights: Sequence[float]) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels of these heights, inches, below one another."""
    figure = new_figure(sum(heights))
    panels = figure.subplots(len(heights), 1, squeeze=False, height_ratios=list(heights))[:, 0]
    return figure, list(panels)


def ledger_figure(rows: Sequence[LedgerRow]) -> Figure:
    """Return what became of the runs."""
    figure, (ax,) = stacked([ledger_height(rows)])
    draw_ledger(ax, rows)
    return figure


def means_figure(contents: Sequence[tuple[str, Sequence[GroupValues]]]) -> Figure:
    """Return a panel of means for each measure: its title and its groups."""
    figure, panels = stacked([panel_height([group.label for group in groups], title) for title, groups in contents])
    for ax, (title, groups) in zip(panels, contents, strict=True):
        draw_panel(ax, groups, title)
    return figure


def slopes_figure(contents: Sequence[tuple[str, Sequence[GroupValues]]]) -> Figure:
    """Return a panel of lines by seed for each measure."""
    figure, panels = stacked([panel_height([group.label for group in groups], title) for title, groups in contents])
    for ax, (title, groups) in zip(panels, contents, strict=True):
        draw_slopes(ax, groups, title)
    return figure


def forest_figure(contents: Sequence[tuple[str, Sequence[Pair]]], names: Mapping[str, str]) -> Figure:
    """Return a panel of paired differences for each measure, and what the short names stand for."""
    key = _key(names)
    heights = [forest_height(pairs, title) for title, pairs in contents]
    figure = new_figure(sum(heights) + LINE_IN * len(key))
    panels = figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
    for ax, (title, pairs) in zip(panels, contents, strict=True):
        draw_forest(ax, pairs, title)
    if key:
        _write_below(figure, key)
    return figure


def _write_below(figure: Figure, key: Sequence[str]) -> None:
    share = LINE_IN * len(key) / figure.get_figheight()
    engine = figure.get_layout_engine()
    assert isinstance(engine, ConstrainedLayoutEngine)
    engine.set(rect=(0, share, 1, 1 - share))
    text = figure.text(0.02, share, "\n".join(key), va="top", size=7, color=style.DARK)
    text.set_in_layout(False)


def fitting(labels: Sequence[str]) -> Mapping[str, str]:
    """Return the labels of a heatmap's columns, or letters for them where they would overlap."""
    room = _HEAT_IN / len(labels)
    return {label: label for label in labels} if all(lines(one) * LINE_IN < room for one in labels) else keys(labels)


def _key(names: Mapping[str, str]) -> list[str]:
    named = (f"{short}: {name}" for name, short in names.items() if short != name)
    return [part for line in named for part in wrapped(line, _KEY_WIDTH).split("\n")]


def fingerprint_figure(found: FingerprintMap) -> Figure:
    """Return the heatmap with the dendrogram above it and the colour bar below."""
    names = fitting(found.labels)
    key = _key(names)
    tall = 0.4 + 0.07 * len(found.labels) if found.merges else 0.05
    below = LINE_IN * (len(key) or 8)
    heat = max(0.145 * len(found.measures), 0.6)
    figure = new_figure(tall + heat + below + 0.6)
    grid = figure.add_gridspec(2, 1, height_ratios=[tall, heat])
    ax = figure.add_subplot(grid[1])
    image = draw_fingerprint(ax, replace(found, labels=tuple(names[label] for label in found.labels)))
    if found.merges:
        draw_dendrogram(figure.add_subplot(grid[0]), found.merges, len(found.labels))
    bar = figure.colorbar(image, ax=ax, orientation="horizontal", aspect=40, pad=0.03, extend="both")
    bar.set_label("Standard deviations from the mean", loc="right")
    bar.outline.set_linewidth(0.4)
    if key:
        _write_below(figure, key)
    return figure


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


def survival_figure(curves: Sequence[SurvivalCurve]) -> Figure:
    """Return the share of agents that is not warned yet, by group."""
    below = sum(wrapped(f"{curve.label} (n={curve.runs})", 40).count("\n") + 1 for curve in curves)
    figure = new_figure(2.2 + 0.15 * below)
    draw_survival(figure.add_subplot(), curves)
    return figure


def cascade_figure(trees: Sequence[CascadeTree]) -> Figure:
    """Return who warned whom in one run of each group."""
    figure, panels = stacked([cascade_height(tree) for tree in trees])
    for ax, tree in zip(panels, trees, strict=True):
        draw_cascade(ax, tree)
    panels[-1].set_xlabel("Step")
    figure.supylabel("Agent", size=7.5)
    return figure


def topdown_figure(found: TopDown) -> Figure:
    """Return the ways through a 3D world."""
    below = sum(wrapped(path.label, 44).count("\n") + 1 for path in found.paths) + 2
    figure = new_figure(3.0 + 0.15 * below)
    draw_topdown(figure.add_subplot(), found)
    return figure
