"""Compares groups of runs: mean and interval of each, and the seed-paired difference to the first model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import pandas as pd

from analysis.groups import group_label
from analysis.intervals import Estimate, estimate
from analysis.run import FloatArray
from analysis.signatures import FAILURE_RATE, describe, discover
from analysis.table import SignatureTable

Group: TypeAlias = tuple[str, ...]
"""The values of the columns that tell groups apart."""

_MOST_COLUMNS = 5
"""Groups that stand side by side in the short table; more stand below one another."""


@dataclass(frozen=True)
class Headline:
    """A short table for the terminal, all texts."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Comparison:
    """The compared groups.

    Attributes:
        frame: one row per measure and group: `measure`, the columns that tell the groups apart, `runs` (of
            whatever status), then `n`, `mean`, `sd`, `low`, `high`, `note` over seeds, then the same of the
            seed-paired differences: `reference`, `n_pairs`, `difference`, `difference_sd`, `difference_low`,
            `difference_high`, `difference_note`.
        group_columns: the columns that tell the groups apart.
        values: by group and measure, the value of each seed: mean of the runs of that seed, such as repeats with
            other sampling seeds.
        estimates: mean and interval by measure and group, as in the frame; only of what the group's runs have, so
            none of measures of 2D worlds for runs of 3D ones.
    """

    frame: pd.DataFrame
    group_columns: tuple[str, ...]
    values: dict[Group, pd.DataFrame]
    estimates: dict[tuple[str, Group], Estimate]

    @property
    def groups(self) -> list[Group]:
        """The groups in the order of their first run."""
        return list(self.values)


def compare(table: SignatureTable, groups: pd.DataFrame) -> Comparison:
    """Compare groups of runs, each by the measures that its runs have.

    Within a group the value of a seed is the mean over its runs; the independent values are those of the seeds.
    Intervals are Student's, 95 %, clipped to the possible range of the measure. Differences are to the group
    with the first model and everything else equal, over the seeds that have a value in both; with one model
    only, to the first value of the first other setting that differs, the world excepted.

    Args:
        table: the runs.
        groups: the columns that tell groups apart, one row per run.
    """
    columns = tuple(groups.columns)
    keys = list(groups.itertuples(index=False, name=None))
    values = {group: _by_seed(table, [key == group for key in keys]) for group in dict.fromkeys(keys)}
    references = {group: _reference(group, list(values), columns) for group in values}
    kept = {group: _measures_of(table, [key == group for key in keys]) for group in values}
    estimates = {
        (measure, group): _estimate(measure, values[group])
        for measure in table.measures
        for group in values
        if measure in kept[group]
    }
    rows = [
        {
            "measure": measure,
            **dict(zip(columns, group, strict=True)),
            "runs": keys.count(group),
            **vars(found),
            **_difference(measure, values, group, references[group]),
        }
        for (measure, group), found in estimates.items()
    ]
    return Comparison(pd.DataFrame(rows), columns, values, estimates)


def _measures_of(table: SignatureTable, chosen: Sequence[bool]) -> set[str]:
    """Return the measures that any of the chosen runs has, defined or not; all when none of them is complete."""
    found = {name for names, mine in zip(table.present, chosen, strict=True) if mine for name in names}
    return set(table.measures) if found == {FAILURE_RATE} else found


def _by_seed(table: SignatureTable, chosen: Sequence[bool]) -> pd.DataFrame:
    """Return the measures by seed, mean over the runs of a seed."""
    rows = table.frame.loc[list(chosen)]
    return rows[list(table.measures)].astype(float).groupby(rows["seed"].to_numpy(), sort=True).mean()


def _reference(group: Group, groups: Sequence[Group], columns: Sequence[str]) -> Group:
    """Return the group that this one is compared with; an empty one if there is none."""
    for index in (index for index, name in enumerate(columns) if name != "world"):
        levels = list(dict.fromkeys(one[index] for one in groups))
        if len(levels) > 1:
            other = (*group[:index], levels[0], *group[index + 1 :])
            return other if other != group and other in groups else ()
    return ()


def _estimate(measure: str, values: pd.DataFrame) -> Estimate:
    described = describe(measure)
    return estimate(_column(values, measure), described.low, described.high)


def _difference(measure: str, values: dict[Group, pd.DataFrame], group: Group, reference: Group) -> dict[str, object]:
    """Return the mean difference to the reference over the seeds that have a value in both."""
    found = Estimate(0, math.nan, math.nan, math.nan, math.nan, "")
    if reference:
        own, other = values[group], values[reference]
        seeds = own.index.intersection(other.index)
        spread = describe(measure).high - describe(measure).low
        found = estimate(_column(own.loc[seeds], measure) - _column(other.loc[seeds], measure), -spread, spread)
    return {
        "reference": group_label(reference),
        "n_pairs": found.n,
        "difference": found.mean,
        "difference_sd": found.sd,
        "difference_low": found.low,
        "difference_high": found.high,
        "difference_note": found.note,
    }


def _column(frame: pd.DataFrame, measure: str) -> FloatArray:
    return frame[measure].to_numpy(dtype=np.float64)


def headline(comparison: Comparison) -> Headline:
    """Return the headline measures: mean and interval, one column a group while they fit, else one row."""
    present = list(dict.fromkeys(measure for measure, _ in comparison.estimates))
    measures = [column for signature in discover() for column in signature.headline_columns(present)]
    seeds = {group: len(values) for group, values in comparison.values.items()}
    cells = {key: _cell(found, seeds[key[1]]) for key, found in comparison.estimates.items()}
    groups = comparison.groups
    if len(groups) > _MOST_COLUMNS:
        long = [
            (measure, group_label(group), cells[measure, group])
            for measure in measures
            for group in groups
            if (measure, group) in cells
        ]
        return Headline(("measure", "group", "mean [95 % interval]"), tuple(long))
    rows = [(measure, *(cells.get((measure, group), "") for group in groups)) for measure in measures]
    return Headline(("measure", *map(group_label, groups)), tuple(rows))


def _cell(found: Estimate, seeds: int) -> str:
    if math.isnan(found.mean):
        return "-"
    interval = "" if math.isnan(found.low) else f" [{found.low:.3g}, {found.high:.3g}]"
    return f"{found.mean:.3g}{interval}" + (f" n={found.n}" if found.n < seeds else "")
