"""Tests that two conditions are the same within a margin, for values of a known range and any distribution."""

import math

import numpy as np

from analysis.arrays import BoolArray, FloatArray

LEVEL = 0.05
_ROUNDING = 1e-12


def equivalence_p(differences: FloatArray, margin: float, widest: float) -> float:
    """Return p of |true mean difference| >= margin: the larger one of Gaffke's bounds of both sides.

    NaN where no difference is too large to be possible; then nothing bounds the mean (Gaffke 2005).

    Args:
        differences: paired differences (n,).
        margin: the difference below which conditions count as the same.
        widest: the size that no difference goes beyond.
    """
    if not math.isfinite(widest):
        return math.nan
    return max(_mean_above(side * differences, margin, widest) for side in (1, -1))


def _mean_above(values: FloatArray, margin: float, greatest: float) -> float:
    """Return p of a true mean >= margin, of values (n,) that are at most the greatest.

    It is P(w @ x >= margin) for the values and the greatest as x, w uniform on the simplex (Varsi 1971).
    """
    below = margin - np.append(values, greatest)
    shares = np.zeros(1 + np.count_nonzero(below >= 0))
    shares[0] = 1.0
    for beyond in below[below < 0]:
        for place, room in enumerate(below[below >= 0], start=1):
            shares[place] = (room * shares[place] - beyond * shares[place - 1]) / (room - beyond)
    return float(shares[-1])


def fewest_for_same(margin: float, widest: float) -> float:
    """Return the least number of seeds that can show that two conditions are the same; NaN where none can."""
    if not math.isfinite(widest):
        return math.nan
    return 1.0 if margin >= widest else float(math.ceil(math.log(LEVEL) / math.log1p(-margin / widest)))


def most_beyond(within: int, n: int) -> float:
    """Return which share of all seeds could differ by more than the margin, where so many of n lie within it.

    The upper end of a one-sided 95 % interval (Clopper and Pearson 1934).
    """
    from scipy.special import betaincinv

    return float(betaincinv(n - within + 1, within, 1 - LEVEL)) if within else 1.0


def are_within(differences: FloatArray, size: FloatArray) -> BoolArray:
    """Return which differences (R, S) are at most of the size of their row (R,), apart from rounding; NaN are not."""
    return np.asarray(np.abs(differences) <= size[:, None] * (1 + _ROUNDING) + _ROUNDING)
