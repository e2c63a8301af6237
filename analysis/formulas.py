"""Formulas that several signatures share; undefined is NaN."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from analysis.run import BoolArray, IntArray


def ratio(part: float, whole: float) -> float:
    """Return part / whole; NaN when the whole is 0."""
    return part / whole if whole else math.nan


def mean(values: Iterable[float]) -> float:
    """Return the arithmetic mean; NaN of nothing."""
    kept = list(values)
    return ratio(math.fsum(kept), len(kept))


def entropy(counts: ArrayLike) -> float:
    """Return Shannon's entropy of counts (k,), bits, 0..log2 k; NaN when all are 0."""
    found = np.asarray(counts, dtype=np.float64)
    total = float(found.sum())
    if not total:
        return math.nan
    shares = found[found > 0] / total
    return float(-(shares * np.log2(shares)).sum()) + 0.0


def normalised_entropy(counts: ArrayLike) -> float:
    """Return the entropy over its greatest value, log2 k, 0..1; NaN when all k counts are 0 or k < 2."""
    categories = np.asarray(counts).size
    return entropy(counts) / math.log2(categories) if categories > 1 else math.nan


def longest_run(flags: BoolArray) -> int:
    """Return the length of the longest unbroken run of True in flags (T,)."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int64), [0]))))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def run_lengths(values: IntArray) -> IntArray:
    """Return the lengths of the runs of equal neighbours in values (T,), in order."""
    starts = np.flatnonzero(np.concatenate(([True], values[1:] != values[:-1])))
    return np.diff(np.concatenate((starts, [len(values)])))
