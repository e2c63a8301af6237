"""Many measures of several pairs at once: step-down max-T inside each pair, Holm's correction over the pairs.

A pair draws one sign per seed for all its measures, so correlated measures cost no power (Westfall and Young 1993;
Romano and Wolf 2005). The least p that can be reached depends on the seeds and the pairs, not on the number of
measures. `benchmarks/calibration.md` shows how well that holds.
"""

import numpy as np

from analysis.arrays import FloatArray, IntArray
from analysis.stats.sign_flip import assignments, share_as_extreme, sign_blocks

TIES = 1e-10
"""Difference within which two statistics are equal."""
_ALL_SIGNS_UP_TO, _LEAST_DRAWS = 11, 999
"""Seeds up to which a simulated test counts all signs; signs that it draws at least above."""


def step_down_p(differences: FloatArray) -> FloatArray:
    """Return the two-sided p of each measure of a pair (M,), corrected over the measures; exact to 16 seeds.

    The statistic is |sum| / sqrt(sum of squares), in which a seed without a value adds 0. The measures are taken from
    the largest statistic down: each is held against the largest null statistic of those that are left.

    Args:
        differences: paired differences (M, n); NaN where a seed has none.
    """
    values = scaled(np.nan_to_num(differences))
    observed = np.abs(values.sum(axis=1))
    order = np.argsort(-observed, kind="stable")
    nulls = (np.abs(values[order] @ block.T) for block in sign_blocks(differences.shape[1]))
    largest_left = (np.maximum.accumulate(null[::-1], axis=0)[::-1] for null in nulls)
    tolerance = np.full(len(order), TIES)
    p = np.empty(len(order))
    p[order] = np.maximum.accumulate(share_as_extreme(largest_left, observed[order], tolerance, differences.shape[1]))
    return p


def scaled(differences: FloatArray) -> FloatArray:
    """Return differences (..., n) over the root of their sum of squares; rows of zeros stay 0."""
    norms = np.sqrt((differences**2).sum(axis=-1, keepdims=True))
    return np.asarray(differences / np.where(norms > 0, norms, 1.0))


def signs_of_simulations(n: int, level: float, rng: np.random.Generator) -> FloatArray:
    """Return the signs (draws, n) by which simulated tests of n seeds are made: all, or enough for p of this level."""
    if n <= _ALL_SIGNS_UP_TO:
        return assignments(n).astype(np.float64)
    return np.asarray(1.0 - 2 * rng.integers(0, 2, size=(max(_LEAST_DRAWS, round(4 / level)), n)))


def over_pairs(p: FloatArray, pair: IntArray) -> FloatArray:
    """Return p values that are corrected inside each pair, corrected over the pairs too (R,).

    As in Holm's method, a p counts as often as pairs are left: those with a measure whose p is no smaller. A pair in
    which one measure differs stays in the count until all its measures do. Else its other measures would err more often
    than the level says.

    Args:
        p: corrected inside each pair (R,); NaN are no tests and stay.
        pair: the pair of each row (R,).
    """
    tests = np.flatnonzero(~np.isnan(p))
    order = tests[np.argsort(p[tests], kind="stable")]
    # The last row of each pair in this order: with it the pair is out of the count.
    last = np.unique(pair[order][::-1], return_index=True)[1]
    ends = np.zeros(len(order), dtype=np.int64)
    ends[len(order) - 1 - last] = 1
    left = len(last) - np.cumsum(ends) + ends
    adjusted = np.full(len(p), np.nan)
    adjusted[order] = np.minimum(np.maximum.accumulate(p[order] * left), 1.0) if len(order) else []
    return adjusted
