"""Draws runs of 2D worlds for a paper: the state after given steps, or the whole paths of the agents."""

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from msgspec.structs import replace

from analysis.figures.shown import ShownGroup
from analysis.grid.grid_run import GridRun
from analysis.grid.plots.occupancy import draw_paths, draw_world
from analysis.plots import style
from analysis.plots.figures import new_figure
from analysis.plots.labels import LINE_IN, wrapped

_MOST_ACROSS = 6
_DOT_PT, _NUMBER_PT = 7.5, 4.2


def sketch(runs: Sequence[tuple[ShownGroup, GridRun]], steps: Sequence[int] | None) -> Figure:
    """Return a figure with a panel per run and step; without steps, a panel per run with the agents' whole paths."""
    panels = [(shown, run, step) for shown, run in runs for step in steps or (None,)]
    in_row = len(steps) if steps and len(steps) > 1 else len(runs)
    across = math.ceil(in_row / math.ceil(in_row / _MOST_ACROSS))
    down = math.ceil(len(panels) / across)
    side = style.width() / across
    titles = [
        wrapped(shown.label, round(16 * side)) + ("" if step is None else f"\nstep {step}") for shown, _, step in panels
    ]
    figure = new_figure(down * (side + LINE_IN * max(title.count("\n") + 1 for title in titles)))
    axes = figure.subplots(down, across, squeeze=False).flat
    for ax in axes[len(panels) :]:
        ax.axis("off")
    for ax, title, (shown, run, step) in zip(axes, titles, panels, strict=False):
        if step is None:
            draw_paths(ax, shown, run)
        else:
            draw_state(ax, shown, run, min(step, run.steps))
        for place in run.world.places:
            ax.text(place.center[0], place.high[1] + 1, place.name, size=6, ha="center", color=style.DARK)
        ax.set_title(title, size=7, color=style.DARK, pad=3)
    return figure


def draw_state(ax: Axes, shown: ShownGroup, run: GridRun, step: int) -> Axes:
    """Draw the agents with their ids after a step, and each agent's last move; `×3` marks a cell with three agents."""
    burning = tuple(fire for fire in run.world.fires if fire.start <= step)
    draw_world(ax, replace(run.world, fires=burning), style.PLACE)
    here = run.there[max(step - 1, 0)]
    before, x, y = max(step - 1, 0), run.x[step], run.y[step]
    ax.plot(
        *(np.array([way[before][here], way[step][here]]) for way in (run.x, run.y)), color=shown.colour, linewidth=0.8
    )
    cells = Counter((int(x[agent]), int(y[agent])) for agent in np.flatnonzero(here))
    ax.plot(
        *zip(*cells, strict=True),
        "o",
        color=shown.colour,
        markersize=_DOT_PT,
        markeredgecolor="white",
        markeredgewidth=0.4,
    )
    for agent in np.flatnonzero(here):
        cell = (int(x[agent]), int(y[agent]))
        if cells[cell]:
            text = str(agent) if cells[cell] == 1 else f"×{cells[cell]}"
            ax.annotate(text, cell, size=_NUMBER_PT, color="white", ha="center", va="center_baseline")
            cells[cell] = 0
    return ax
