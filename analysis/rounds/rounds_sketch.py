"""Draws the agents' decisions of several runs in one figure."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from analysis.figures.shown import ShownGroup
from analysis.plots.rounds import Lanes, lanes_figure
from analysis.rounds.rounds_figures import kinds_of, values_of
from analysis.rounds.rounds_run import RoundsRun


def sketch(runs: Sequence[tuple[ShownGroup, RoundsRun]], steps: Sequence[int] | None) -> Figure:
    """Draw a row per agent of each run, with its answers to the first kind of question; `steps` limits the rounds."""
    kind = kinds_of(runs[0][1])[0]
    labels = runs[0][1].declared.actions[kind].labels
    figure = lanes_figure([Lanes(shown.label, run.id, values_of(run, kind), labels) for shown, run in runs])
    if steps:
        for ax in figure.axes[: len(runs)]:
            ax.set_xlim(max(steps[0], 1) - 0.5, max(steps[-1], 1) + 0.5)
    return figure
