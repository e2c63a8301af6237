"""Draws whole figures: panels with their legends and colour bars."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from analysis.plots import style
from analysis.plots.fingerprints import FingerprintMap, draw_dendrogram, draw_fingerprint
from analysis.plots.forest import Pair, draw_forest, forest_height
from analysis.plots.labels import LINE_IN, keys, lines, wrapped
from analysis.plots.panel import GroupValues, Scale, draw_panel, panel_height

_KEY_WIDTH = 46
_HEAT_IN = 1.6
"""Width of a heatmap without the names of its rows, inches."""


def new_figure(height: float) -> Figure:
    """Return an empty figure of the given height, inches."""
    return Figure(figsize=(style.width(), height), dpi=style.DPI, layout="constrained", facecolor="white")


def stacked(heights: Sequence[float]) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels below each other, which have the given heights, inches."""
    figure = new_figure(sum(heights))
    panels = figure.subplots(len(heights), 1, squeeze=False, height_ratios=list(heights))[:, 0]
    return figure, list(panels)


def means_figure(contents: Sequence[tuple[str, Sequence[GroupValues], Scale]]) -> Figure:
    """Return a figure with a panel of means for each measure, from its title, groups and scale."""
    figure, panels = stacked([panel_height([group.label for group in groups], title) for title, groups, _ in contents])
    for ax, (title, groups, scale) in zip(panels, contents, strict=True):
        draw_panel(ax, groups, title, scale)
    return figure


def forest_figure(contents: Sequence[tuple[str, Sequence[Pair]]], names: Mapping[str, str]) -> Figure:
    """Return a figure with a panel of paired differences for each measure, and a key to the short names."""
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
    """Return the shown labels of a heatmap's columns: the labels, or letters if any labels would overlap."""
    room = _HEAT_IN / len(labels)
    return (
        {label: label for label in labels} if all(lines(label) * LINE_IN < room for label in labels) else keys(labels)
    )


def _key(names: Mapping[str, str]) -> list[str]:
    named = (f"{short}: {name}" for name, short in names.items() if short != name)
    return [part for line in named for part in wrapped(line, _KEY_WIDTH).split("\n")]


def fingerprint_figure(fingerprint: FingerprintMap) -> Figure:
    """Return the heatmap with the dendrogram above and the colour bar below."""
    names = fitting(fingerprint.labels)
    key = _key(names)
    tall = 0.4 + 0.07 * len(fingerprint.labels) if fingerprint.merges else 0.05
    below = LINE_IN * (len(key) or 8)
    heat = max(0.145 * len(fingerprint.measures), 0.6)
    figure = new_figure(tall + heat + below + 0.6)
    grid = figure.add_gridspec(2, 1, height_ratios=[tall, heat])
    ax = figure.add_subplot(grid[1])
    image = draw_fingerprint(ax, replace(fingerprint, labels=tuple(names[label] for label in fingerprint.labels)))
    if fingerprint.merges:
        draw_dendrogram(figure.add_subplot(grid[0]), fingerprint.merges, len(fingerprint.labels))
    bar = figure.colorbar(image, ax=ax, orientation="horizontal", aspect=40, pad=0.03, extend="both")
    bar.set_label("Standard deviations from the mean", loc="right")
    bar.outline.set_linewidth(0.4)
    if key:
        _write_below(figure, key)
    return figure
