"""Group-sequential levels: how small p must be at each of several looks at growing data.

The test statistic of n pairs is treated as a sum of n independent steps of variance 1; its density is computed from
look to look (Armitage, McPherson and Rowe 1969). Up to the look at n of N pairs, the share n / N of the error may be
spent (Lan and DeMets 1983). `benchmarks/calibration.md` shows how well the levels hold for the sign-flip test and for
t.
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
"""Overall errors between which a sequential p is searched."""
_A_DECADE = 16
_HALVINGS = 60


@dataclass(frozen=True)
class _Sums:
    """Densities of the sums of A tests that are not significant yet: points (A, Q) and their probabilities (A, Q)."""

    points: FloatArray
    mass: FloatArray

    def beyond(self, bound: FloatArray, spread: float) -> FloatArray:
        """Return the probability of a sum beyond +-bound (A,) after a step with the given standard deviation (A,)."""
        from scipy.special import ndtr

        below = ndtr((-bound[:, None] - self.points) / spread) + ndtr((self.points - bound[:, None]) / spread)
        return np.asarray((self.mass * below).sum(axis=1))

    def within(self, bound: FloatArray, spread: float) -> "_Sums":
        """Return the densities of the sums that are within +-bound (A,) after a further step."""
        count = max(_FEWEST_NODES, round(_NODES_A_STEP * 2 * float(bound.max()) / spread))
        nodes, weights = np.polynomial.legendre.leggauss(count)
        points = bound[:, None] * nodes
        mass = np.empty_like(points)
        for row, (old, new) in enumerate(zip(self.points, points, strict=True)):
            step = np.exp(-(((new[:, None] - old) / spread) ** 2) / 2) / (spread * np.sqrt(2 * np.pi))
            mass[row] = bound[row] * weights * (step @ self.mass[row])
        return _Sums(points, mass)


def _start(tests: int) -> _Sums:
    return _Sums(np.zeros((tests, 1)), np.ones((tests, 1)))


def _spreads(looks: Sequence[int]) -> FloatArray:
    """Return the standard deviation of the step from each look to the next (K,)."""
    return np.sqrt(np.diff(np.asarray(looks, dtype=np.float64), prepend=0.0))


def levels(looks: Sequence[int], alpha: FloatArray) -> FloatArray:
    """Return the two-sided levels of the single looks (K, A) that give an overall error of alpha.

    Args:
        looks: pairs at each look, ascending (K).
        alpha: overall errors, between 0 and 1 (A,).
    """
    from scipy.special import ndtr

    found = np.empty((len(looks), len(alpha)))
    sums = _start(len(alpha))
    for row, (spread, spent) in enumerate(zip(_spreads(looks), np.diff(looks, prepend=0), strict=True)):
        bound = _bound(sums, float(spread), alpha * spent / looks[-1], 40.0 * looks[row] ** 0.5)
        found[row] = 2 * ndtr(-bound / looks[row] ** 0.5)
        sums = sums.within(bound, float(spread))
    return found


def _bound(sums: _Sums, spread: float, chance: FloatArray, high: float) -> FloatArray:
    """Return the bounds that are exceeded with the given probabilities (A,), by bisection."""
    lower, upper = np.zeros(len(chance)), np.full(len(chance), high)
    for _ in range(_HALVINGS):
        middle = (lower + upper) / 2
        passed = sums.beyond(middle, spread) > chance
        lower, upper = np.where(passed, middle, lower), np.where(passed, upper, middle)
    return upper


def sequential_p(looks: Sequence[int], p: FloatArray) -> FloatArray:
    """Return the least overall error at which a test is significant at any look so far (R,); 1 if it never is.

    These are valid p values whenever you stop, so corrections for several tests apply to them (Liu and Anderson 2008).

    Args:
        looks: number of pairs at every planned look, ascending (K).
        p: two-sided p at the first k <= K looks (k, R); NaN where nothing was tested.
    """
    from scipy.interpolate import PchipInterpolator

    error, level = _table(tuple(looks))
    found = np.ones(p.shape[1])
    for row, at in zip(p, level, strict=False):
        inside = row <= at[-1]
        back = PchipInterpolator(np.log(at), np.log(error), extrapolate=False)
        own = np.exp(back(np.log(np.maximum(row[inside], at[0]))))
        found[inside] = np.minimum(found[inside], own)
    return found


@lru_cache(maxsize=8)
def _table(looks: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """Return overall errors (A,), and the levels of the looks for each of them (K, A)."""
    decades = np.log10(_MOST / _LEAST)
    error = np.geomspace(_LEAST, _MOST, round(_A_DECADE * decades))
    return error, levels(looks, error)
