"""Corrects p values for several tests: by step-down max-T within a pair of groups, by Holm's method over the pairs.

In a pair, all measures of a seed change sign together, so correlated measures cost no power (Westfall and Young 1993;
Romano and Wolf 2005). The smallest p that can occur depends on the number of seeds and of pairs of groups, but not on
the number of measures. `benchmarks/calibration.md` shows how often the test errs if nothing differs.
"""

import numpy as np

from analysis.arrays import FloatArray, IntArray
from analysis.stats.sign_flip import assignments, share_as_extreme, sign_blocks

TIES = 1e-10
"""Difference below which two statistics count as equal."""
_ALL_SIGNS_UP_TO, _LEAST_DRAWS = 11, 999
"""A simulated test uses all signs up to this number of seeds; for more seeds, at least this number of random signs."""


def step_down_p(differences: FloatArray) -> FloatArray:
    """Return the two-sided p of each measure of a pair (M,), corrected over the measures; exact up to 16 seeds.

    The statistic is |sum| / sqrt(sum of squares), in which a seed without a value adds 0. The measure with the largest
    statistic comes first. Each is compared with the largest null statistic among itself and the measures after it.

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
    """Return differences (..., n) divided by the root of their sum of squares; rows of zeros stay 0."""
    norms = np.sqrt((differences**2).sum(axis=-1, keepdims=True))
    return np.asarray(differences / np.where(norms > 0, norms, 1.0))


def signs_of_simulations(n: int, level: float, rng: np.random.Generator) -> FloatArray:
    """Return assignments of signs (draws, n) for simulated tests of n seeds.

    For few seeds these are all assignments, for more seeds enough random ones to find p values below the given level.
    """
    if n <= _ALL_SIGNS_UP_TO:
        return assignments(n).astype(np.float64)
    return np.asarray(1.0 - 2 * rng.integers(0, 2, size=(max(_LEAST_DRAWS, round(4 / level)), n)))


def over_pairs(p: FloatArray, pair: IntArray) -> FloatArray:
    """Correct p values for the number of pairs (R,), after they were corrected within each pair.

    As in Holm's method, a p is multiplied by the number of pairs that are left. A pair is left as long as any of its
    measures has a p that is at least as large; otherwise its other measures would err more often than the level allows.

    Args:
        p: p values corrected within each pair (R,); NaN, for a row without test, stays NaN.
        pair: the pair of each row (R,).
    """
    tests = np.flatnonzero(~np.isnan(p))
    order = tests[np.argsort(p[tests], kind="stable")]
    # The last row of each pair in this order: after it the pair no longer counts.
    last = np.unique(pair[order][::-1], return_index=True)[1]
    ends = np.zeros(len(order), dtype=np.int64)
    ends[len(order) - 1 - last] = 1
    left = len(last) - np.cumsum(ends) + ends
    adjusted = np.full(len(p), np.nan)
    adjusted[order] = np.minimum(np.maximum.accumulate(p[order] * left), 1.0) if len(order) else []
    return adjusted
