"""Builds the plots of an analysis, with captions."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import pandas as pd

from analysis.figures.measures import fingerprint_map, group_values, pairs_of, scale_of
from analysis.figures.members import shown_groups
from analysis.figures.shown import ShownGroup
from analysis.plots import Picture, figures
from analysis.plots.labels import keys
from analysis.plots.panel import GroupValues, Scale
from analysis.stats.fingerprint import Fingerprint
from analysis.tables.comparison import Comparison
from analysis.tables.texts import number, with_interval


def in_words(groups: Sequence[GroupValues], scale: Scale) -> str:
    """Return as text each group's mean with its 95 % interval, then the values of chance and of the best policy."""
    means = [f"{group.label} {with_interval(group.mean, group.low, group.high)}" for group in groups]
    marks = [
        f"{what} {number(value)}"
        for what, value in (("chance alone", scale.null), ("the best policy", scale.best))
        if not math.isnan(value)
    ]
    return f"{', '.join([*means, *marks])}."


_MEANS = (
    "Marks are means over seeds (discs for baselines), bars are their 95 % intervals, and dots are single seeds. n is "
    "the number of seeds with a value."
)
_NULL = " The dashed line is the value by chance alone, and the dotted line that of the best scripted policy."
_PAIRS = (
    "Mean difference paired by seed, with its 95 % interval. A filled mark with a star is significant after "
    "correction for all tests. A tilde marks a difference within the declared margin. Grey rows were not tested. n is "
    "the number of pairs of seeds."
)

MOST_PANELS = 24
"""Maximum number of measures in a plot; in some worlds every action or place has a measure of its own."""


def every_picture(
    comparison: Comparison,
    contrasts: pd.DataFrame,
    validation: pd.DataFrame,
    fingerprint: Fingerprint,
) -> list[Picture]:
    """Return the fingerprint, and the means and paired differences of every signature."""
    shown = shown_groups(comparison)
    pictures = [fingerprint_picture(fingerprint)]
    for name in comparison.headlines:
        pictures.append(means_picture(comparison, shown, name, validation))
        pictures.append(forest_picture(contrasts, comparison, shown, name))
    return [picture for picture in pictures if picture is not None]


def letters_of(contrasts: pd.DataFrame, shown: Sequence[ShownGroup]) -> Mapping[str, str]:
    """Return the letters that stand for compared groups and contexts in every plot of differences."""
    ordered = dict.fromkeys(part for condition in shown for part in condition.group)
    named = {*contrasts["reference"], *contrasts["level"]}
    contexts = [context for context in dict.fromkeys(map(str, contrasts["context"])) if context]
    return keys([*(part for part in ordered if part in named), *contexts])


def means_picture(
    comparison: Comparison, shown: Sequence[ShownGroup], signature: str, validation: pd.DataFrame | None = None
) -> Picture:
    """Return the plot of a signature's means; if it has many measures, only the first are shown."""
    measures = comparison.headlines[signature]
    drawn = measures[:MOST_PANELS]
    contents = [
        (
            comparison.describe(measure).label,
            group_values(comparison, shown, measure),
            scale_of(comparison, measure, validation),
        )
        for measure in drawn
    ]
    says = " ".join(f"{title}: {in_words(groups, scale)}" for title, groups, scale in contents)
    shown_of = f" {len(drawn)} of {len(measures)} measures are shown; all are in comparison.md."
    left_out = shown_of if drawn != measures else ""
    return Picture(
        signature,
        f"{signature}: means",
        _MEANS + _NULL + left_out,
        partial(figures.means_figure, contents),
        says,
        contents,
    )


def forest_picture(
    contrasts: pd.DataFrame, comparison: Comparison, shown: Sequence[ShownGroup], signature: str
) -> Picture | None:
    """Return the plot of a signature's paired differences; None if nothing is compared."""
    measures = comparison.headlines[signature][:MOST_PANELS]
    rows = contrasts[contrasts["measure"].isin(measures)]
    names = letters_of(rows, shown)
    panels = [(comparison.describe(measure).label, pairs_of(rows, measure, names)) for measure in measures]
    contents = [(title, pairs) for title, pairs in panels if pairs]
    if not contents:
        return None
    title = f"{signature}: paired differences"
    draw = partial(figures.forest_figure, contents, names)
    return Picture(f"{signature}_differences", title, _PAIRS, draw, data=contents)


@dataclass(frozen=True)
class Standardised:
    """The standardised mean of one measure in one group: a cell of the heatmap."""

    measure: str
    group: str
    z: float


def fingerprint_picture(fingerprint: Fingerprint) -> Picture | None:
    """Return the heatmap of the standardised means; None with fewer than two groups, or without values."""
    if len(fingerprint.levels) < 2 or not fingerprint.measures:
        return None
    shown = fingerprint_map(fingerprint)
    caption = (
        "Means of the headline measures, standardised over all runs of the groups. Rows are measures, and columns are "
        "groups. The tree joins similar groups (average linkage). Each percentage says in how many resamples of the "
        "seeds the tree joins the same groups. There is no overall score."
    )
    cells = [
        Standardised(measure, label, float(value))
        for measure, row in zip(shown.measures, shown.z, strict=True)
        for label, value in zip(shown.labels, row, strict=True)
    ]
    return Picture("fingerprint", "Fingerprints", caption, partial(figures.fingerprint_figure, shown), data=cells)
