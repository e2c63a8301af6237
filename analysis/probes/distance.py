"""The distance between two samples of choices, and its floor: the distance that chance alone would give.

For two samples of m and n choices, with counts a_k and b_k of choice k, the distance (total variation) is d = 1/2 sum_k
|a_k / m - b_k / n|. Its floor is the mean of d over all splits of the m + n choices into samples of these sizes. If
both samples come from one distribution, the expected d equals the floor, for any sizes (the permutation null, Good
2005, Permutation, Parametric and Bootstrap Tests of Hypotheses). A distance above the floor indicates a difference.
"""

import math
from collections import Counter
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.random import Generator

SPLITS = 999
"""Number of random splits from which the p of a single moment is computed."""
_TIES = 1e-12


@dataclass(frozen=True)
class ChoiceDistance:
    """The distance between two samples of choices in one moment.

    Attributes:
        distance: total variation, 0..1.
        floor: mean distance if both samples came from one distribution.
        p: share of random splits with at least this distance.
    """

    distance: float
    floor: float
    p: float

    @property
    def excess(self) -> float:
        """The distance minus its floor."""
        return self.distance - self.floor


def apart(first: Counter[str], second: Counter[str], rng: Generator | None) -> ChoiceDistance:
    """Compare two non-empty samples; without a random generator, `p` is NaN."""
    m, n = first.total(), second.total()
    choices = sorted(first.keys() | second.keys())
    a = np.array([first[choice] for choice in choices], dtype=np.int64)
    b = np.array([second[choice] for choice in choices], dtype=np.int64)
    distance = 0.5 * float(np.abs(a / m - b / n).sum())
    floor = 0.5 * sum(expected_gap(int(count), m, n) for count in a + b)
    return ChoiceDistance(distance, floor, math.nan if rng is None else _p(a + b, m, n, distance, rng))


@lru_cache(maxsize=65536)
def expected_gap(count: int, m: int, n: int) -> float:
    """Return the mean difference between the shares of one choice in two random samples of sizes m and n.

    The choice was made `count` times in all. The result is the mean of |k / m - (count - k) / n|, where k of these
    choices are in the first sample. k is hypergeometric, since m of m + n choices are taken at random.
    """
    least = max(0, count - n)
    ways = math.comb(count, least) * math.comb(m + n - count, m - least)
    total = gaps = 0
    for k in range(least, min(count, m) + 1):
        total += ways
        gaps += ways * abs(k * n - (count - k) * m)
        ways = ways * (count - k) * (m - k) // ((k + 1) * (n - count + k + 1))
    return gaps / (total * m * n)


def _p(pooled: np.ndarray[tuple[int], np.dtype[np.int64]], m: int, n: int, distance: float, rng: Generator) -> float:
    if distance <= _TIES:
        return 1.0
    taken = rng.multivariate_hypergeometric(pooled, m, size=SPLITS)
    drawn = 0.5 * np.abs(taken / m - (pooled - taken) / n).sum(axis=1)
    return float((1 + (drawn >= distance - _TIES).sum()) / (1 + SPLITS))
