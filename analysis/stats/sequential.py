"""Computes how small p must be at each of several looks at growing data.

The test statistic of n pairs is treated as a sum of n independent steps of variance 1. The probability density of this
sum is computed for each look from the look before (Armitage, McPherson and Rowe 1969). All looks together may err with
probability alpha. The looks until n of N pairs may err with probability alpha n / N (Lan and DeMets 1983).
`benchmarks/calibration.md` shows how often sign-flip and t tests with several looks err if nothing differs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from analysis.arrays import FloatArray

_NODES_A_STEP = 4
"""Number of points of integration per standard deviation of the step between two looks."""
_FEWEST_NODES = 40
_LEAST, _MOST = 1e-9, 0.999
"""Smallest and largest sequential p that can be found."""
_A_DECADE = 16
_HALVINGS = 60


@dataclass(frozen=True)
class _Sums:
    """The distributions of the sums of A tests that no look has found significant so far.

    Attributes:
        points: possible values of the sum, (A, Q).
        mass: probability of each value, (A, Q).
    """

    points: FloatArray
    mass: FloatArray

    def beyond(self, bound: FloatArray, spread: float) -> FloatArray:
        """Return the probability (A,) that no earlier look was significant, but the next sum is beyond the bound.

        `spread` is the standard deviation of the step.
        """
        from scipy.special import ndtr

        below = ndtr((-bound[:, None] - self.points) / spread) + ndtr((self.points - bound[:, None]) / spread)
        return np.asarray((self.mass * below).sum(axis=1))

    def within(self, bound: FloatArray, spread: float) -> "_Sums":
        """Return the distributions of the sums after one more step, cut to sums between -bound and bound, (A,)."""
        count = max(_FEWEST_NODES, round(_NODES_A_STEP * 2 * float(bound.max()) / spread))
        nodes, weights = np.polynomial.legendre.leggauss(count)
        points = bound[:, None] * nodes
        mass = np.empty_like(points)
        for row, (old, new) in enumerate(zip(self.points, points, strict=True)):
            step = np.exp(-(((new[:, None] - old) / spread) ** 2) / 2) / (spread * np.sqrt(2 * np.pi))
            mass[row] = bound[row] * weights * (step @ self.mass[row])
        return _Sums(points, mass)


def levels(looks: Sequence[int], alpha: FloatArray) -> FloatArray:
    """Return the level of the two-sided test at each look (K, A), so that the error over all looks is alpha.

    Args:
        looks: pairs at each look, ascending (K).
        alpha: overall errors, between 0 and 1 (A,).
    """
    from scipy.special import ndtr

    alphas = np.empty((len(looks), len(alpha)))
    sums = _Sums(np.zeros((len(alpha), 1)), np.ones((len(alpha), 1)))
    for row, added in enumerate(np.diff(looks, prepend=0).tolist()):
        bound = _bound(sums, added**0.5, alpha * added / looks[-1], 40.0 * looks[row] ** 0.5)
        alphas[row] = 2 * ndtr(-bound / looks[row] ** 0.5)
        sums = sums.within(bound, added**0.5)
    return alphas


def _bound(sums: _Sums, spread: float, chance: FloatArray, high: float) -> FloatArray:
    lower, upper = np.zeros(len(chance)), np.full(len(chance), high)
    for _ in range(_HALVINGS):
        middle = (lower + upper) / 2
        passed = sums.beyond(middle, spread) > chance
        lower, upper = np.where(passed, middle, lower), np.where(passed, upper, middle)
    return upper


def sequential_p(looks: Sequence[int], p: FloatArray) -> FloatArray:
    """Return the p value of each row over all looks so far, (R,).

    The p value is the least error over all looks at which the test would be significant at one of these looks, or 1.

    These p values are valid whenever you stop, so they can be corrected for several tests (Liu and Anderson 2008).

    Args:
        looks: number of pairs at every planned look, ascending (K).
        p: two-sided p at the first k <= K looks (k, R); NaN where nothing was tested.
    """
    from scipy.interpolate import PchipInterpolator

    error, level = _table(tuple(looks))
    overall = np.ones(p.shape[1])
    for row, at in zip(p, level, strict=False):
        inside = row <= at[-1]
        back = PchipInterpolator(np.log(at), np.log(error), extrapolate=False)
        own = np.exp(back(np.log(np.maximum(row[inside], at[0]))))
        overall[inside] = np.minimum(overall[inside], own)
    return overall


@lru_cache(maxsize=8)
def _table(looks: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """Return possible errors over all looks, (A,), and for each of them the level of the test at each look, (K, A)."""
    decades = np.log10(_MOST / _LEAST)
    error = np.geomspace(_LEAST, _MOST, round(_A_DECADE * decades))
    return error, levels(looks, error)
