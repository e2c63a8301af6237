"""Compares groups of runs: mean and interval of each, and the seed-paired difference to the first model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from analysis.groups import group_label
from analysis.intervals import Estimate, estimate
from analysis.run import FloatArray
from analysis.signatures import describe, discover
from analysis.table import SignatureTable

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
    """

    frame: pd.DataFrame
    group_columns: tuple[str, ...]
    values: dict[tuple[str, ...], pd.DataFrame]

    @property
    def groups(self) -> list[tuple[str, ...]]:
        """The groups in the order of their first run."""
        return list(self.values)


def compare(table: SignatureTable, groups: pd.DataFrame) -> Comparison:
    """Compare groups of runs.

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
    values = {
        group: _by_seed(table, [key == group for key in keys]) for group in dict.fromkeys(keys)
    }
    references = {group: _reference(group, list(values), columns) for group in values}
    rows = [
        {
            "measure": measure,
            **dict(zip(columns, group, strict=True)),
            "runs": keys.count(group),
            **_estimates(measure, values[group], values.get(references[group]), references[group]),
        }
        for measure in table.measures
        for group in values
    ]
    return Comparison(pd.DataFrame(rows), columns, values)


def _by_seed(table: SignatureTable, chosen: Sequence[bool]) -> pd.DataFrame:
    """Return the measures by seed, mean over the runs of a seed."""
    rows = table.frame.loc[list(chosen)]
    return rows[list(table.measures)].astype(float).groupby(rows["seed"].to_numpy(), sort=True).mean()


def _reference(
    group: tuple[str, ...], groups: Sequence[tuple[str, ...]], columns: Sequence[str]
) -> tuple[str, ...]:
    """Return the group that this one is compared with; an empty one if there is none."""
    for index in (index for index, name in enumerate(columns) if name != "world"):
        levels = list(dict.fromkeys(one[index] for one in groups))
        if len(levels) > 1:
            other = (*group[:index], levels[0], *group[index + 1 :])
            return other if other != group and other in groups else ()
    return ()


def _estimates(
    measure: str, own: pd.DataFrame, other: pd.DataFrame | None, reference: tuple[str, ...]
) -> dict[str, object]:
    described = describe(measure)
    mean = estimate(_column(own, measure), described.low, described.high)
    found: dict[str, object] = {
        "n": mean.n, "mean": mean.mean, "sd": mean.sd, "low": mean.low, "high": mean.high, "note": mean.note,
    }  # fmt: skip
    spread = described.high - described.low
    paired = _paired(measure, own, other, spread)
    return found | {
        "reference": group_label(reference),
        "n_pairs": paired.n if paired else 0,
        "difference": paired.mean if paired else np.nan,
        "difference_sd": paired.sd if paired else np.nan,
        "difference_low": paired.low if paired else np.nan,
        "difference_high": paired.high if paired else np.nan,
        "difference_note": paired.note if paired else "",
    }


def _paired(measure: str, own: pd.DataFrame, other: pd.DataFrame | None, spread: float) -> Estimate | None:
    """Return the mean difference over the seeds that have a value in both."""
    if other is None:
        return None
    seeds = own.index.intersection(other.index)
    return estimate(_column(own.loc[seeds], measure) - _column(other.loc[seeds], measure), -spread, spread)


def _column(frame: pd.DataFrame, measure: str) -> FloatArray:
    return frame[measure].to_numpy(dtype=np.float64)


def headline(comparison: Comparison) -> Headline:
    """Return the headline measures: mean and interval, one column a group while they fit, else one row."""
    frame = comparison.frame
    present = list(dict.fromkeys(frame["measure"]))
    measures = [column for signature in discover() for column in signature.headline_columns(present)]
    cells = {
        (row["measure"], tuple(row[list(comparison.group_columns)])): _cell(row) for _, row in frame.iterrows()
    }
    groups = comparison.groups
    if len(groups) > _MOST_COLUMNS:
        long = [(measure, group_label(group), cells[measure, group]) for measure in measures for group in groups]
        return Headline(("measure", "group", "mean [95 % interval]"), tuple(long))
    rows = [(measure, *(cells[measure, group] for group in groups)) for measure in measures]
    return Headline(("measure", *map(group_label, groups)), tuple(rows))


def _cell(row: pd.Series[object]) -> str:
    mean, low, high = (float(str(row[name])) for name in ("mean", "low", "high"))
    if np.isnan(mean):
        return "-"
    return f"{mean:.3g}" if np.isnan(low) else f"{mean:.3g} [{low:.3g}, {high:.3g}]"
