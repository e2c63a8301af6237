"""Describes each group of runs by the mean and interval of every measure; `analysis.stats` compares groups."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pandas as pd

from analysis.arrays import IntArray
from analysis.measure import Measure
from analysis.signatures import describe, discover
from analysis.stats.imputed import variance_of_copies, widened
from analysis.stats.intervals import Estimate, Estimates, estimates
from analysis.stats.pairing import are_outcomes
from analysis.stats.values import Group, SeedValues, seed_values
from analysis.tables.signature_table import SignatureTable


@dataclass(frozen=True)
class Comparison:
    """The groups with their means.

    Attributes:
        frame: one row per measure and group. Its columns are `measure`, the columns that define groups, `baseline`,
            `runs` (their number, of any status), then `n`, `mean`, `sd`, `low`, `high`, `interval`, `note` over seeds.
        values: for each group, a table of seeds by measures. A value is the mean over the runs of the seed, such as
            repeats with other sampling seeds.
        estimates: mean and interval by measure and group, for the measures that the group's runs have.
        baselines: groups of scripted models for comparison.
        models: models of all runs, also of runs that a filter excludes, in the order of first runs. Their colours
            depend on this order.
        runs: class of the runs of each group; empty if unknown.
    """

    frame: pd.DataFrame
    group_columns: tuple[str, ...]
    values: dict[Group, pd.DataFrame]
    estimates: dict[tuple[str, Group], Estimate]
    baselines: frozenset[Group] = frozenset()
    models: tuple[str, ...] = ()
    runs: Mapping[Group, type] = field(default_factory=dict)

    @property
    def groups(self) -> list[Group]:
        """The groups in the order of their first run."""
        return list(self.values)

    @cached_property
    def headlines(self) -> dict[str, list[str]]:
        """The available headline measures, by signature."""
        present = list(dict.fromkeys(measure for measure, _ in self.estimates))
        columns = {signature.name: signature.headline_columns(present) for signature in discover()}
        return {name: measures for name, measures in columns.items() if measures}

    def describe(self, measure: str) -> Measure:
        """Return the description of a measure, from the module of the groups' form if they all have one form."""
        runs = {run for group, run in self.runs.items() if (measure, group) in self.estimates}
        return describe(measure, runs.pop() if len(runs) == 1 else None)


def compare(table: SignatureTable, groups: pd.DataFrame | None = None) -> Comparison:
    """Describe each group of runs by its measures.

    Within a group, the value of a seed is the mean over its runs; seeds are the independent units. The 95 % intervals
    are clipped to the possible values of the measure; see `analysis.stats.intervals`.
    """
    values = seed_values(table, groups)
    measure, group = np.nonzero(values.present.T)
    estimates = _estimates(values, measure, group)
    keys = [(values.measures[m], values.groups[g]) for m, g in zip(measure, group, strict=True)]
    estimated = {key: estimates.row(index) for index, key in enumerate(keys)}
    rows = [
        {
            "measure": name,
            **dict(zip(values.columns, key, strict=True)),
            "baseline": bool(values.baseline[g]),
            "runs": int(values.runs[g]),
            **vars(estimated[name, key]),
        }
        for (name, key), g in zip(keys, group, strict=True)
    ]
    by_group = {key: _of_group(values, index) for index, key in enumerate(values.groups)}
    baselines = frozenset(key for key, is_one in zip(values.groups, values.baseline, strict=True) if is_one)
    runs = {key: asked.run for key, asked in zip(values.groups, values.questions, strict=False)}
    return Comparison(pd.DataFrame(rows), values.columns, by_group, estimated, baselines, runs=runs)


def _estimates(values: SeedValues, measure: IntArray, group: IntArray) -> Estimates:
    described = [describe(name) for name in values.measures]
    low, high = (np.array([getattr(measure, end) for measure in described]) for end in ("low", "high"))
    outcome = are_outcomes(values.values)
    # A group's mean is a difference from 0, so copies with drawn labels add to its variance in the same way.
    added = np.array(
        [
            variance_of_copies(values.copies[m][g]) if m in values.copies else 0.0
            for m, g in zip(measure.tolist(), group.tolist(), strict=True)
        ]
    )
    wide = widened(values.values[group, :, measure], added)
    return estimates(wide, low[measure], high[measure], outcome[measure])


def _of_group(values: SeedValues, index: int) -> pd.DataFrame:
    asked = values.asked[index]
    seeds = pd.Index([seed for seed, mine in zip(values.seeds, asked, strict=True) if mine], name="seed")
    return pd.DataFrame(values.values[index, asked], index=seeds, columns=list(values.measures))
