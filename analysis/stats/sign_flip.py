"""The sign-flip test of paired differences; under the null hypothesis, both signs are equally likely."""

from collections.abc import Iterable, Iterator
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from analysis.arrays import FloatArray
from foundry.seeding import stream

EXACT_UP_TO = 16
"""Number of pairs up to which all 2^n assignments of signs are used."""
DRAWS = 9_999
"""Number of random assignments of signs that are used for more than EXACT_UP_TO pairs."""
_AT_ONCE = 256
"""Number of assignments of signs whose test statistics are in memory at once."""
_ROWS_AT_ONCE = 64
"""Number of rows that are computed at once; for each row, one mean per assignment of signs is in memory."""
_TIES = 1e-10
"""Two sums of differences count as equal if they differ by less than _TIES times the sum of absolute differences."""


@lru_cache(maxsize=8)
def assignments(n: int) -> npt.NDArray[np.int8]:
    """Return assignments of signs, +1 or -1, to n differences, (draws, n).

    Up to n = EXACT_UP_TO, these are all assignments whose first sign is +1, since the assignments that begin with -1
    mirror them. For larger n, these are DRAWS random assignments, the same each time.
    """
    if n <= EXACT_UP_TO:
        bits = np.arange(2 ** (n - 1))[:, None] >> np.arange(n - 1)[None, :] & 1
        signs = np.hstack([np.ones((len(bits), 1)), 1 - 2 * bits]).astype(np.int8)
    else:
        drawn, signs = stream(n, "sign-flip"), np.empty((DRAWS, n), dtype=np.int8)
        for part in np.split(signs, range(_AT_ONCE, DRAWS, _AT_ONCE)):
            part[:] = 1 - 2 * drawn.integers(0, 2, size=part.shape)
    signs.flags.writeable = False
    return signs


def sign_blocks(n: int) -> Iterator[FloatArray]:
    """Yield all rows of `assignments(n)`, in blocks of rows (draws, n)."""
    signs = assignments(n)
    return (signs[start : start + _AT_ONCE].astype(np.float64) for start in range(0, len(signs), _AT_ONCE))


def share_as_extreme(blocks: Iterable[FloatArray], observed: FloatArray, tolerance: FloatArray, n: int) -> FloatArray:
    """Return the p value of each observed statistic, (rows,), from the statistics under all assignments of signs.

    Each block (rows, draws) has the statistics under some of the assignments.

    If assignments are random, the actual data counts as one of them.
    """
    itself = 0 if n <= EXACT_UP_TO else 1
    extreme, draws = np.full(len(observed), itself, dtype=np.int64), itself
    for null in blocks:
        extreme += (null >= (observed - tolerance)[:, None]).sum(axis=1)
        draws += null.shape[1]
    return np.asarray(extreme / draws, dtype=np.float64)


def sign_flip_p(differences: FloatArray) -> FloatArray:
    """Return the two-sided p of each row's mean (rows,), exact up to n = 16.

    Args:
        differences: paired differences (rows, n), n >= 1.

    Raises:
        ValueError: a difference is NaN, which has no p value.
    """
    if np.isnan(differences).any():
        raise ValueError("A paired difference is NaN: leave incomplete pairs out.")
    n = differences.shape[1]
    sums = (np.abs(differences @ block.T) for block in sign_blocks(n))
    return share_as_extreme(sums, np.abs(differences.sum(axis=1)), _TIES * np.abs(differences).sum(axis=1), n)


def sign_flip_interval(differences: FloatArray, level: float = 0.95) -> tuple[FloatArray, FloatArray]:
    """Return both ends (rows,) of the interval of mean differences that the two-sided test does not reject.

    A shift d below the mean is at least as extreme under the assignments in which the mean of the flipped values, or of
    the other values, is at most d. So the ends are order statistics of means of parts. They are infinite for n < 6.

    Args:
        differences: paired differences (rows, n), n >= 1, without NaN.
        level: level of the interval; 0 is outside the interval exactly if `sign_flip_p` is at most 1 - level.
    """
    parts = np.split(differences, range(_ROWS_AT_ONCE, len(differences), _ROWS_AT_ONCE))
    ends = np.concatenate([_ends(part, level) for part in parts])
    return ends[:, 0], ends[:, 1]


def _ends(differences: FloatArray, level: float) -> FloatArray:
    n = differences.shape[1]
    flipped = assignments(n) < 0
    size = flipped.sum(axis=1)
    tolerance = _TIES * np.abs(differences).sum(axis=1, keepdims=True) / 2
    sums = differences @ flipped.T.astype(np.float64)
    both = np.stack([sums, differences.sum(axis=1, keepdims=True) - sums])
    both[np.abs(both) <= tolerance] = 0.0
    with np.errstate(invalid="ignore"):
        both /= np.stack([size, n - size])[:, None, :]
    itself = 0 if n <= EXACT_UP_TO else 1
    rank = int((1 - level) * (len(flipped) + itself) + _TIES) - itself
    least = np.where(size % n, both.min(axis=0), -np.inf)
    greatest = np.where(size % n, both.max(axis=0), np.inf)
    low, high = np.partition(least, rank, axis=1)[:, rank], -np.partition(-greatest, rank, axis=1)[:, rank]
    return np.stack([low, high], axis=1)


def upper_sign_flip_p(values: FloatArray) -> FloatArray:
    """Return for each row the p value of a one-sided test that its mean is above 0, (rows,); exact up to n = 16.

    Args:
        values: values (rows, n), n >= 1, that are symmetric around 0 under the null hypothesis.

    Raises:
        ValueError: a value is NaN, which has no p value.
    """
    if np.isnan(values).any():
        raise ValueError("A value is NaN: leave it out.")
    n = values.shape[1]
    sums = (np.hstack([sums, -sums]) for block in sign_blocks(n) for sums in (values @ block.T,))
    return share_as_extreme(sums, values.sum(axis=1), _TIES * np.abs(values).sum(axis=1), n)


def least_p(n: int) -> float:
    """Return the smallest p value that a test of n pairs can have."""
    return 2.0 ** (1 - n) if n <= EXACT_UP_TO else max(2.0 ** (1 - n), 1 / (DRAWS + 1))


def fewest_pairs(level: float, most: int = 64) -> int | None:
    """Return the smallest number of pairs that can reach p <= level; None if no number up to `most` can."""
    return next((n for n in range(1, most + 1) if least_p(n) <= level), None)
