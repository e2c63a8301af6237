"""Converts tables to the content of plots: values by group, paired differences, fingerprints."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis.figures.shown import ShownGroup
from analysis.plots.fingerprints import FingerprintMap, Merge
from analysis.plots.forest import Pair
from analysis.plots.panel import GroupValues, Scale
from analysis.tables.comparison import Comparison

if TYPE_CHECKING:
    from analysis.stats.fingerprint import Fingerprint


def group_values(comparison: Comparison, groups: Sequence[ShownGroup], measure: str) -> list[GroupValues]:
    """Return the values of one measure, for each group in which it is defined."""
    return [_values(comparison, shown, measure) for shown in groups if (measure, shown.group) in comparison.estimates]


def scale_of(comparison: Comparison, measure: str, validation: pd.DataFrame | None = None) -> Scale:
    """Return a measure's limits, its null, and the best policy's mean if this is the same in all worlds."""
    known = comparison.describe(measure)
    rows = None if validation is None else validation[validation["measure"] == measure]
    random, best = (math.nan if rows is None else agreed(rows[name]) for name in ("random", "best"))
    return Scale(known.low, known.high, random if known.null is None else known.null.value, best)


def agreed(values: pd.Series[float]) -> float:
    """Return the value that all rows have; NaN if the rows have different values, or if there are no rows."""
    return float(values.iloc[0]) if values.nunique(dropna=False) == 1 else math.nan


def _values(comparison: Comparison, shown: ShownGroup, measure: str) -> GroupValues:
    estimate, column = comparison.estimates[measure, shown.group], comparison.values[shown.group][measure]
    return GroupValues(
        label=shown.label,
        values=column.to_numpy(dtype=np.float64),
        mean=estimate.mean,
        low=estimate.low,
        high=estimate.high,
        index=shown.index,
        seeds=tuple(int(seed) for seed in column.index),
        baseline=shown.baseline,
    )


def pairs_of(contrasts: pd.DataFrame, measure: str, names: Mapping[str, str]) -> list[Pair]:
    """Return the paired differences of one measure over all decisions, including unreadable ones."""
    rows = contrasts[(contrasts["measure"] == measure) & ~contrasts["readable_only"].astype(bool)]
    return [_pair(row, names) for row in rows.to_dict("records")]


def _pair(row: Mapping[Any, Any], names: Mapping[str, str]) -> Pair:
    level, reference = (names.get(str(row[name]), str(row[name])) for name in ("level", "reference"))
    context = f" ({names.get(row['context'], row['context'])})" if row["context"] else ""
    return Pair(
        label=f"{level} \N{MINUS SIGN} {reference}{context}",
        difference=float(row["difference"]),
        low=float(row["low"]),
        high=float(row["high"]),
        pairs=int(row["n_pairs"]),
        significant=bool(row["significant"]),
        equivalent=bool(row["equivalent"]),
        tested=bool(row["headline"]),
    )


def fingerprint_map(fingerprint: Fingerprint) -> FingerprintMap:
    """Return a fingerprint with the groups sorted as in its dendrogram, in which similar groups are neighbours."""
    levels = [str(level) for level in fingerprint.levels]
    order, merges = dendrogram(fingerprint.linkage, fingerprint.support, len(levels))
    values = fingerprint.z.to_numpy(dtype=np.float64)[order]
    return FingerprintMap(
        labels=tuple(levels[index] for index in order),
        measures=tuple(str(measure) for measure in fingerprint.measures),
        z=values.T,
        merges=tuple(merges),
    )


def dendrogram(linkage: Any, support: Any, count: int) -> tuple[list[int], list[Merge]]:
    """Return the order of the leaves of a dendrogram, and its merges; positions in the merges refer to this order.

    Args:
        linkage: the merges (count - 1, 4), as in `analysis.stats.fingerprint.Fingerprint`, or None.
        support: share of resamples in which each merge occurs (count - 1,).
        count: number of leaves.
    """
    if linkage is None:
        return list(range(count)), []
    leaves: dict[int, list[int]] = {index: [index] for index in range(count)}
    for number, (left, right) in enumerate(np.asarray(linkage)[:, :2].astype(int).tolist()):
        leaves[count + number] = leaves[left] + leaves[right]
    order = leaves[count + len(linkage) - 1]
    place: dict[int, float] = {leaf: float(index) for index, leaf in enumerate(order)}
    height = dict.fromkeys(range(count), 0.0)
    merges = []
    for number, (left, right, distance, _) in enumerate(np.asarray(linkage, dtype=float).tolist()):
        first, other = int(left), int(right)
        merges.append(
            Merge(
                place[first], place[other], height[first], height[other], distance, float(np.asarray(support)[number])
            )
        )
        place[count + number] = (place[first] + place[other]) / 2
        height[count + number] = distance
    return order, merges
