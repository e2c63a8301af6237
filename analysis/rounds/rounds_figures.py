"""Plots of worlds in rounds: the decisions of each agent, and their shares or means by round."""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from analysis.arrays import FloatArray
from analysis.figures.shown import ShownGroup, example_caption
from analysis.form import RunTable
from analysis.plots import Picture
from analysis.plots.panel import Scale
from analysis.plots.rounds import Curve, Lanes, curves_figure, lanes_figure
from analysis.rounds.rounds_run import NONE, RoundsRun
from analysis.stats.intervals import estimates
from foundry.declared import Actions

MOST_LABELS = 4
"""Maximum number of labels per kind of question that get a panel: the most frequent ones."""


class RoundsFigures:
    """Collects what the plots show of each group: an example run, and means by round."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._examples: dict[ShownGroup, RoundsRun] = {}
        self._curves: dict[tuple[str, str], dict[ShownGroup, list[FloatArray]]] = {}
        self._actions: dict[str, Actions] = {}

    def add(self, shown: ShownGroup, run: RoundsRun, seed: int) -> None:
        """Collect the data that the figures of a group need from one run of this group."""
        if seed == self._seed:
            self._examples.setdefault(shown, run)
        self._actions |= {kind: run.declared.actions[kind] for kind in kinds_of(run)}
        for kind in kinds_of(run):
            named = run.shares(kind) if run.declared.actions[kind].labels else {"": run.means(kind)}
            for label, curve in named.items():
                self._curves.setdefault((kind, label), {}).setdefault(shown, []).append(curve)

    def pictures(self, order: Sequence[ShownGroup]) -> list[Picture]:
        """Return two plots for each kind of question, with the groups in the given order."""
        return [picture for kind in self._actions for picture in (self._rounds(kind, order), self._lanes(kind, order))]

    def tables(self, _: Sequence[ShownGroup]) -> list[RunTable]:
        """Return no tables: the plots show everything."""
        return []

    def _rounds(self, kind: str, order: Sequence[ShownGroup]) -> Picture:
        caption = "Mean over the agents of a run, then over runs, with its 95 % interval over seeds, by round."
        panels = [(title, [*self._means(kind, label, order)]) for label, title in self._titles(kind)]
        drawn = partial(curves_figure, panels, Scale(*self._bounds(kind)))
        return Picture(f"{kind}_by_round", f"{kind}: round by round", caption, drawn, data=panels)

    def _titles(self, kind: str) -> list[tuple[str, str]]:
        """Return each label that gets a panel, with the panel's title.

        The label for doing nothing gets a panel only if no other label exists.
        """
        known = self._actions[kind]
        if not known.labels:
            return [("", f"{kind} (mean)")]
        common = sorted(known.labels, key=lambda label: -_mean(self._curves[kind, label]))
        telling = [label for label in common if label != known.idle][:MOST_LABELS] or list(known.labels)
        return [(label, f"{kind}: {label} (share)") for label in telling]

    def _means(self, kind: str, label: str, order: Sequence[ShownGroup]) -> Iterator[Curve]:
        by_group = self._curves[kind, label]
        for shown in (condition for condition in order if condition in by_group):
            values = _stacked(by_group[shown])
            means = estimates(values, *(np.full(len(values), bound) for bound in self._bounds(kind)))
            yield Curve(shown.label, means.mean, means.low, means.high, values.shape[1], shown.index, shown.baseline)

    def _bounds(self, kind: str) -> tuple[float, float]:
        known = self._actions[kind]
        if known.labels:
            return 0.0, 1.0
        return (-np.inf if known.low is None else known.low, np.inf if known.high is None else known.high)

    def _lanes(self, kind: str, order: Sequence[ShownGroup]) -> Picture:
        known = self._actions[kind]
        caption = f"{example_caption(self._seed)} One row per agent, rounds from left to right. White: no decision."
        runs = [(shown, self._examples[shown]) for shown in order if kind in kinds_of(self._examples.get(shown))]
        lanes = [Lanes(shown.label, run.id, values_of(run, kind), known.labels) for shown, run in runs]
        drawn = partial(lanes_figure, lanes)
        return Picture(f"{kind}_by_agent", f"{kind}: agent by agent", caption, drawn, data=lanes)


def kinds_of(run: RoundsRun | None) -> list[str]:
    """Return the kinds of question that a run asked and that have decisions."""
    return [] if run is None else [kind for kind in run.declared.actions if (run.kind == kind).any()]


def values_of(run: RoundsRun, kind: str) -> FloatArray:
    """Return the decided numbers, or the indices of the chosen labels, (N, T); NaN where no decision is readable."""
    if not run.declared.actions[kind].labels:
        return np.where(run.was_read(kind), run.numbers(kind), np.nan).T
    choices = run.choices(kind)
    return np.where(run.was_read(kind) & (choices != NONE), choices, np.nan).T


def _mean(curves: dict[ShownGroup, list[FloatArray]]) -> float:
    return float(np.mean([np.nan_to_num(curve).mean() for group in curves.values() for curve in group]))


def _stacked(curves: Sequence[FloatArray]) -> FloatArray:
    """Return curves as columns, (T, runs); after the end of a shorter run, values are NaN."""
    stacked = np.full((max(map(len, curves)), len(curves)), np.nan)
    for place, curve in enumerate(curves):
        stacked[: len(curve), place] = curve
    return stacked
