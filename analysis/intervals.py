"""Means and their intervals over independent values, one a seed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analysis.run import FloatArray

LEVEL = 0.95
FEWEST_FOR_CLAIMS = 6
"""With fewer values no exact test can reach p < .05; then numbers describe these runs and claim nothing."""


@dataclass(frozen=True)
class Estimate:
    """A mean and its interval.

    Attributes:
        n: number of values.
        mean: NaN without values.
        sd: standard deviation, ddof 1; NaN with fewer than two values.
        low: lower end of the interval; NaN where there is none.
        high: upper end.
        note: what keeps the interval from being there, or from being more than a description; "" for nothing.
    """

    n: int
    mean: float
    sd: float
    low: float
    high: float
    note: str


def estimate(values: FloatArray, low: float = -math.inf, high: float = math.inf) -> Estimate:
    """Return the mean with its 95 % Student-t interval, mean -+ t(n-1) sd / sqrt(n).

    Args:
        values: independent values (n,); NaN are left out.
        low: least possible value, to which the interval is clipped.
        high: greatest possible value.
    """
    kept = values[~np.isnan(values)]
    n = len(kept)
    if n == 0:
        return Estimate(0, math.nan, math.nan, math.nan, math.nan, "no value")
    mean = float(kept.mean())
    if n == 1:
        return Estimate(1, mean, math.nan, math.nan, math.nan, "one value")
    few = f"descriptive (n < {FEWEST_FOR_CLAIMS})" if n < FEWEST_FOR_CLAIMS else ""
    # A standard deviation of rounding errors would make an interval out of nothing.
    if np.ptp(kept) <= 1e-12 * max(1.0, abs(mean)):
        return Estimate(n, mean, 0.0, math.nan, math.nan, "; ".join(filter(None, ("no variation", few))))
    sd = float(kept.std(ddof=1))
    half = student_quantile(n - 1) * sd / math.sqrt(n)
    return Estimate(n, mean, sd, max(mean - half, low), min(mean + half, high), few)


def student_quantile(freedom: int, level: float = LEVEL) -> float:
    """Return the two-sided quantile of Student's t."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + level / 2))
