"""Pairs the values of two groups by seed, and bounds the differences if runs are missing."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.arrays import FloatArray
from analysis.signatures import describe, is_of_form, is_readable_only
from analysis.stats.factors import Pair, pairs
from analysis.stats.imputed import variance_of_copies, widened
from analysis.stats.intervals import Estimates, estimates
from analysis.stats.values import BoolArray, SeedValues, select

_VALUES_AT_ONCE = 2**18
"""Number of values that are in memory at once, for the first group of each pair of groups."""


@dataclass(frozen=True)
class Paired:
    """The values of two groups by seed, in R rows: one row per measure and pair of groups.

    Attributes:
        pair: the pairs of groups, by row.
        measure: indices of the measures (R,).
        level: values of the first groups (R, S); NaN where undefined or missing.
        reference: values of the second groups (R, S).
        missing: planned seeds without a pair because a run is missing (R, S).
        undefined: seeds with complete runs, but without a pair because the measure is undefined in one (R, S).
        low: least possible values of the measures (R,).
        high: greatest possible values (R,).
        added: what copies with random labels add to the variance of the mean difference (R,); see `imputed`.
    """

    pair: tuple[Pair, ...]
    measure: npt.NDArray[np.intp]
    level: FloatArray
    reference: FloatArray
    missing: BoolArray
    undefined: BoolArray
    low: FloatArray
    high: FloatArray
    added: FloatArray

    @property
    def difference(self) -> FloatArray:
        """Differences between the two groups by row and seed, (R, S); NaN for incomplete pairs.

        The differences are spread so that the variance of their mean grows by `added`.
        """
        return widened(self.level - self.reference, self.added)

    def of_rows(self, rows: npt.NDArray[np.intp]) -> Paired:
        """Return the pairs of only the given rows."""
        arrays = {field.name: getattr(self, field.name)[rows] for field in fields(self) if field.name != "pair"}
        return replace(self, pair=tuple(self.pair[row] for row in rows), **arrays)

    def of_seeds(self, seeds: BoolArray) -> Paired:
        """Return the pairs of only the given seeds (S,)."""
        by_seed = ("level", "reference", "missing", "undefined")
        return replace(self, **{name: getattr(self, name)[:, seeds] for name in by_seed})

    def where(self, seen: BoolArray) -> Paired:
        """Return the pairs of the seeds that `seen` marks in each row (R, S); other seeds count as not planned."""
        level, reference = (np.where(seen, values, np.nan) for values in (self.level, self.reference))
        missing, undefined = self.missing & seen, self.undefined & seen
        return replace(self, level=level, reference=reference, missing=missing, undefined=undefined)

    def estimates(self) -> Estimates:
        """Return the mean difference of each row and its interval, clipped to the possible differences."""
        return estimates(self.difference, self.low - self.high, self.high - self.low, beside_sign_flips=True)


def pair_up(values: SeedValues) -> Iterator[Paired]:
    """Yield a row for every measure and every pair of groups with this measure, in blocks that fit into memory.

    Worlds that ask different questions are compared only by measures of their own form, since other measures count all
    questions together. All rows of a pair are in the same block. At least one block is yielded, perhaps without rows.
    """
    all_pairs = pairs(values)
    sides = np.array([(pair.level, pair.reference) for pair in all_pairs], dtype=np.intp).reshape(-1, 2).T
    pair, measure = np.nonzero(values.present[sides[0]] & values.present[sides[1]] & _comparable(values, all_pairs))
    described = [describe(name) for name in values.measures]
    low, high = (np.array([getattr(measure, end) for measure in described]) for end in ("low", "high"))
    together = max(1, _VALUES_AT_ONCE // (len(values.seeds) * max(1, len(values.measures))))
    for first in range(0, max(len(all_pairs), 1), together):
        start, end = np.searchsorted(pair, (first, first + together))
        own, of = pair[start:end], measure[start:end]
        (level, reference), missing, undefined = _sides(values, sides[:, own], of)
        yield Paired(
            pair=tuple(all_pairs[index] for index in own),
            measure=of,
            level=level,
            reference=reference,
            missing=missing,
            undefined=undefined,
            low=low[of],
            high=high[of],
            added=_added(values, sides[:, own], of),
        )


def _added(values: SeedValues, groups: npt.NDArray[np.intp], measure: npt.NDArray[np.intp]) -> FloatArray:
    added = np.zeros(len(measure))
    for row in np.flatnonzero(np.isin(measure, list(values.copies))):
        copies = values.copies[int(measure[row])]
        added[row] = variance_of_copies(copies[groups[0, row]] - copies[groups[1, row]])
    return added


def comparable_measures(values: SeedValues, groups: BoolArray) -> BoolArray:
    """Return which measures are comparable between all given groups (G,) that have them (M,)."""
    comparable = np.ones(len(values.measures), dtype=np.bool_)
    alike: dict[tuple[str, type, str], list[int]] = {}
    for group in np.flatnonzero(groups).tolist() if values.questions else ():
        asked = values.questions[group]
        alike.setdefault((asked.world, asked.run, repr(asked.actions)), []).append(group)
    for first, second in itertools.combinations(alike.values(), 2):
        shared = values.present[first].any(axis=0) & values.present[second].any(axis=0)
        comparable &= ~shared | _means_the_same(values, first[0], second[0])
    return comparable


def _comparable(values: SeedValues, all_pairs: Sequence[Pair]) -> BoolArray:
    rows = [_means_the_same(values, pair.level, pair.reference) for pair in all_pairs]
    return np.array(rows, dtype=np.bool_).reshape(len(all_pairs), len(values.measures))


def _means_the_same(values: SeedValues, first: int, second: int) -> BoolArray:
    first_asked, other = (values.questions[group] if values.questions else None for group in (first, second))
    if first_asked is None or other is None or first_asked.are_like(other):
        return np.ones(len(values.measures), dtype=np.bool_)
    own = first_asked.run is other.run
    return np.array([own and is_of_form(name, first_asked.run) for name in values.measures], dtype=np.bool_)


def _sides(
    values: SeedValues, groups: npt.NDArray[np.intp], measure: npt.NDArray[np.intp]
) -> tuple[tuple[FloatArray, FloatArray], BoolArray, BoolArray]:
    """Return four arrays (R, S): the values of both groups, which pairs lack a run, and which pairs are undefined."""
    first, second = (values.values[group, :, measure] for group in groups)
    lacking = np.isnan(first), np.isnan(second)
    complete, asked = values.complete[groups], values.asked[groups]
    undefined = (lacking[0] & complete[0]) | (lacking[1] & complete[1])
    return (first, second), (asked[0] | asked[1]) & (lacking[0] | lacking[1]) & ~undefined, undefined


def row_frame(values: SeedValues, paired: Paired, declared: Sequence[str]) -> pd.DataFrame:
    """Return a frame with the columns that identify each row."""
    names = list(values.measures)
    chosen = select(names, declared)[paired.measure]
    baseline = np.array([pair.baseline for pair in paired.pair], dtype=bool)
    columns = [values.columns.index(pair.factor) for pair in paired.pair]
    twins = np.array([is_readable_only(name) for name in names], dtype=bool)
    frame = {
        "measure": [names[index] for index in paired.measure],
        "signature": [names[index].partition(".")[0] for index in paired.measure],
        "headline": chosen & ~baseline,
        "readable_only": twins[paired.measure],
        "baseline": baseline,
        "factor": [pair.factor for pair in paired.pair],
        "level": [values.groups[pair.level][at] for pair, at in zip(paired.pair, columns, strict=True)],
        "reference": [values.groups[pair.reference][at] for pair, at in zip(paired.pair, columns, strict=True)],
        "context": [pair.context for pair in paired.pair],
    }
    return pd.DataFrame(frame)


def pair_of(frame: pd.DataFrame) -> pd.Series[int]:
    """Return the index of each row's pair of groups (R,)."""
    return frame.groupby(["factor", "level", "reference", "context"], sort=False, dropna=False).ngroup()


def mean_where(values: FloatArray, chosen: BoolArray) -> FloatArray:
    """Return the mean of the chosen values of each row (R,); NaN if none is chosen."""
    count = chosen.sum(axis=1)
    return np.asarray(np.where(chosen, values, 0.0).sum(axis=1) / np.where(count, count, np.nan))


def bounds(paired: Paired) -> tuple[FloatArray, FloatArray]:
    """Return the least and the greatest mean difference (R,) that is possible, as missing runs may have any value.

    They are NaN if no run is missing, or if the values of the measure have no limits.
    """
    return _bound(paired, paired.low, paired.high), _bound(paired, paired.high, paired.low)


def _bound(paired: Paired, level: FloatArray, reference: FloatArray) -> FloatArray:
    """Return the mean difference if the missing runs have the given values (R,)."""
    first = np.where(np.isnan(paired.level), level[:, None], paired.level)
    second = np.where(np.isnan(paired.reference), reference[:, None], paired.reference)
    used = paired.missing | ~np.isnan(paired.difference)
    bounded = np.isfinite(paired.low) & np.isfinite(paired.high) & paired.missing.any(axis=1)
    difference = np.where(bounded[:, None] & used, first, 0.0) - np.where(bounded[:, None] & used, second, 0.0)
    return np.where(bounded, mean_where(difference, used), np.nan)


_TIE = 1e-12


def superiority(differences: FloatArray) -> FloatArray:
    """Return the share of pairs with a positive difference in each row (rows,); a tie counts half."""
    tie = _TIE * np.maximum(np.abs(differences).max(axis=1, keepdims=True), 1.0)
    greater, equal = (differences > tie).mean(axis=1), (np.abs(differences) <= tie).mean(axis=1)
    return np.asarray(greater + 0.5 * equal, dtype=np.float64)


def hedges_g_z(mean: FloatArray, sd: FloatArray, n: int) -> FloatArray:
    """Return J(n - 1) mean / sd of paired differences (rows,), where J is Hedges' exact correction; NaN if sd is 0."""
    if n < 2:
        return np.full(len(mean), np.nan)
    return hedges_correction(n - 1) * mean / np.where(sd > 0, sd, np.nan)


def hedges_correction(freedom: int) -> float:
    """Return J = Gamma(f/2) / (sqrt(f/2) Gamma((f-1)/2)), which corrects a biased d (Hedges 1981); 0 for f = 1."""
    if freedom < 2:
        return 0.0
    return math.exp(math.lgamma(freedom / 2) - math.lgamma((freedom - 1) / 2)) / math.sqrt(freedom / 2)


def are_outcomes(values: FloatArray) -> BoolArray:
    """Return for each measure whether its values (..., M) are 0 and 1 and no other number, (M,); NaN is ignored."""
    flat = values.reshape(-1, values.shape[-1])
    zeros, ones = (flat == 0), (flat == 1)
    nothing_else = (zeros | ones | np.isnan(flat)).all(axis=0)
    return np.asarray(zeros.any(axis=0) & ones.any(axis=0) & nothing_else)
