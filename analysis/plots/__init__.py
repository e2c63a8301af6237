"""Draws results; computes none."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from analysis.comparison import Comparison
from analysis.groups import group_label
from analysis.plots import style
from analysis.plots.panel import GroupValues, draw_panel, panel_height
from analysis.signatures import describe, discover


def plot_signatures(comparison: Comparison, folder: Path) -> list[Path]:
    """Write one PNG per signature, with its headline measures below one another; returns the files."""
    folder.mkdir(parents=True, exist_ok=True)
    present = list(dict.fromkeys(measure for measure, _ in comparison.estimates))
    written = []
    for signature in discover():
        measures = signature.headline_columns(present)
        if measures:
            path = folder / f"{signature.name}.png"
            _write(path, measures, comparison)
            written.append(path)
    return written


def _write(path: Path, measures: Sequence[str], comparison: Comparison) -> None:
    with matplotlib.rc_context(), warnings.catch_warnings():
        # A name in a script that no installed font has is drawn as boxes; that is seen, and no cause to stop.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(style.settings())
        figure = signature_figure(measures, comparison)
        # No software entry: its version would change the bytes.
        figure.savefig(path, format="png", dpi=style.DPI, metadata={"Software": None})


def signature_figure(measures: Sequence[str], comparison: Comparison) -> Figure:
    """Return a figure with a panel for each of these measures."""
    contents = [(group_values(comparison, measure), describe(measure).label) for measure in measures]
    heights = [panel_height([group.label for group in groups], title) for groups, title in contents]
    size = (style.WIDTH_IN, sum(heights))
    figure = Figure(figsize=size, dpi=style.DPI, layout="constrained", facecolor="white")
    panels = figure.subplots(len(measures), 1, squeeze=False, height_ratios=heights)[:, 0]
    for ax, (groups, title) in zip(panels, contents, strict=True):
        draw_panel(ax, groups, title)
    return figure


def group_values(comparison: Comparison, measure: str) -> list[GroupValues]:
    """Return the results of one measure by group, without the groups that do not have it."""
    keys = [(index, group, (measure, group)) for index, group in enumerate(comparison.groups)]
    found = [(index, group, comparison.estimates[key]) for index, group, key in keys if key in comparison.estimates]
    return [
        GroupValues(
            label=group_label(group),
            values=comparison.values[group][measure].to_numpy(dtype=np.float64),
            mean=one.mean,
            low=one.low,
            high=one.high,
            index=index,
        )
        for index, group, one in found
    ]
