"""Tests whether two conditions are equal within a margin; the values have known limits, but any distribution."""

import math

import numpy as np

from analysis.arrays import BoolArray, FloatArray

LEVEL = 0.05
_ROUNDING = 1e-12


def equivalence_p(differences: FloatArray, margin: float, widest: float) -> float:
    """Return p of the hypothesis |true mean difference| >= margin: the larger of Gaffke's bounds for both directions.

    It is NaN if `widest` is infinite, because then nothing bounds the mean (Gaffke 2005).

    Args:
        differences: paired differences (n,).
        margin: the difference below which conditions count as equal.
        widest: the largest possible |difference|.
    """
    if not math.isfinite(widest):
        return math.nan
    return max(_mean_above(side * differences, margin, widest) for side in (1, -1))


def _mean_above(values: FloatArray, margin: float, greatest: float) -> float:
    """Return p of the hypothesis that the mean is at least the margin, for values (n,) that cannot exceed `greatest`.

    It is P(w @ x >= margin), where x holds the values and `greatest`, and w is uniform on the simplex (Varsi 1971).
    """
    below = margin - np.append(values, greatest)
    shares = np.zeros(1 + np.count_nonzero(below >= 0))
    shares[0] = 1.0
    for beyond in below[below < 0]:
        for place, room in enumerate(below[below >= 0], start=1):
            shares[place] = (room * shares[place] - beyond * shares[place - 1]) / (room - beyond)
    return float(shares[-1])


def fewest_for_same(margin: float, widest: float) -> float:
    """Return the smallest number of seeds that can show that two conditions are equal; NaN if no number can."""
    if not math.isfinite(widest):
        return math.nan
    return 1.0 if margin >= widest else float(math.ceil(math.log(LEVEL) / math.log1p(-margin / widest)))


def most_beyond(within: int, n: int) -> float:
    """Return an upper bound for the share of all seeds that differ by more than the margin.

    In a sample of n seeds, `within` seeds did not differ by more.

    It is the upper end of a one-sided 95 % interval (Clopper and Pearson 1934).
    """
    from scipy.special import betaincinv

    return float(betaincinv(n - within + 1, within, 1 - LEVEL)) if within else 1.0


def are_within(differences: FloatArray, size: FloatArray) -> BoolArray:
    """Return whether each |difference| (R, S) is at most the size of its row (R,), apart from rounding."""
    return np.asarray(np.abs(differences) <= size[:, None] * (1 + _ROUNDING) + _ROUNDING)
