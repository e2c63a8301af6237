"""Formulas for the agreement of choices about the same things, beyond chance; undefined values are NaN."""

import math
from dataclasses import dataclass

import numpy as np

from analysis.arrays import IntArray
from analysis.formulas import mean, ratio


@dataclass(frozen=True)
class Interval:
    """A 95 % interval; its ends are NaN if it is undefined."""

    low: float
    high: float


def joint_counts(first: IntArray, second: IntArray) -> IntArray:
    """Return how often each pair of choices occurs, (choices, choices); the rows (n,) hold indices from 0."""
    size = int(max(first.max(initial=0), second.max(initial=0))) + 1
    return np.bincount(first * size + second, minlength=size * size).reshape(size, size)


def cohen_kappa(first: IntArray, second: IntArray) -> float:
    """Return Cohen's kappa of two rows of choices, (n,) each: -1..1; NaN if chance agreement is 1 or n is 0.

    Source: Cohen 1960.
    """
    return _kappa(joint_counts(first, second))


def _kappa(joint: IntArray) -> float:
    pairs = int(joint.sum())
    # The numbers are whole, multiplied by pairs squared, so that a chance agreement of 1 is exact.
    agreed = pairs * int(np.trace(joint))
    chance = int((joint.sum(axis=0) * joint.sum(axis=1)).sum())
    return ratio(agreed - chance, pairs * pairs - chance)


def kappa_interval(first: IntArray, second: IntArray) -> Interval:
    """Return an interval for Cohen's kappa of two rows of n independent choices, by the jackknife (Tukey 1958).

    The interval is NaN if kappa is undefined for all choices, or for all choices but one.
    """
    from scipy.special import stdtrit

    count = len(first)
    if count < 2:
        return Interval(math.nan, math.nan)
    joint = joint_counts(first, second)
    # Leaving out equal pairs gives equal counts.
    without = {cell: _kappa(joint - (np.arange(joint.size).reshape(joint.shape) == cell)) for cell in range(joint.size)}
    left_out = np.array([without[cell] for cell in (first * len(joint) + second).tolist()])
    error = math.sqrt((count - 1) * float(left_out.var()))
    kappa, half = cohen_kappa(first, second), float(stdtrit(count - 1, 0.975)) * error
    return Interval(kappa - half, kappa + half)


def pairwise_agreement(counts: IntArray) -> float:
    """Return the share of pairs of choices about the same thing that are equal, as a mean over things.

    NaN if `counts` has no things.

    Args:
        counts: how often each choice was made about each thing, (things, choices); at least two choices per thing.
    """
    made = counts.sum(axis=1)
    return mean(((counts * (counts - 1)).sum(axis=1) / (made * (made - 1))).tolist())


def fleiss_kappa(counts: IntArray) -> float:
    """Return Fleiss' kappa, -1..1; NaN if all choices are the same, or if there are none.

    Chance agreement comes from the pooled choices about all things. With equally many choices about each thing, this is
    the measure of Fleiss 1971. Otherwise the agreement is a mean over things with equal weights, and the pool contains
    more choices about some things than about others.

    Args:
        counts: as for `pairwise_agreement`.
    """
    total = int(counts.sum())
    chance = ratio(float((counts.sum(axis=0).astype(np.float64) ** 2).sum()), float(total) ** 2)
    return ratio(pairwise_agreement(counts) - chance, 1 - chance)


def krippendorff_alpha(counts: IntArray) -> float:
    """Return Krippendorff's alpha of nominal choices, -1..1; NaN if all choices are equal, or if there are none.

    Alpha is computed from coincidences, and allows any number of choices about each thing. Source: Krippendorff 2011.

    Args:
        counts: how often each choice was made about each thing, (things, choices); things with one choice are left out.
    """
    counts = counts[counts.sum(axis=1) > 1].astype(np.float64)
    made, totals = counts.sum(axis=1), counts.sum(axis=0)
    number = float(totals.sum())
    differ = float(((made**2 - (counts**2).sum(axis=1)) / np.where(made > 1, made - 1, 1)).sum())
    return 1 - (number - 1) * ratio(differ, number**2 - float((totals**2).sum()))
