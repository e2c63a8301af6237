"""The sign-flip test of paired differences: the null says that either sign was as likely."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from analysis.run import FloatArray
from foundry.seeding import stream

EXACT_UP_TO = 16
"""Pairs up to which all 2^n assignments of signs are counted."""
DRAWS = 9_999
"""Random assignments above."""
_ROWS_AT_ONCE = 64
_TIES = 1e-10
"""Part of the sum of absolute differences within which two sums are equal."""


@lru_cache(maxsize=32)
def assignments(n: int) -> FloatArray:
    """Return signs +1 and -1 (draws, n).

    To n = EXACT_UP_TO all those whose first sign is +1, since the others mirror them; above, DRAWS seeded ones.
    """
    if n <= EXACT_UP_TO:
        bits = np.arange(2 ** (n - 1))[:, None] >> np.arange(n - 1)[None, :] & 1
        signs = np.hstack([np.ones((len(bits), 1)), 1.0 - 2.0 * bits])
    else:
        signs = 1.0 - 2.0 * stream(n, "sign-flip").integers(0, 2, size=(DRAWS, n))
    signs.flags.writeable = False
    return signs


def share_as_extreme(null: FloatArray, observed: FloatArray, tolerance: FloatArray, n: int) -> FloatArray:
    """Return p of statistics (rows,) under those of the assignments (rows, draws); a drawn p counts the data itself."""
    itself = 0.0 if n <= EXACT_UP_TO else 1.0
    extreme = np.asarray((null >= (observed - tolerance)[:, None]).sum(axis=1), dtype=np.float64)
    return np.asarray((extreme + itself) / (null.shape[1] + itself))


def sign_flip_p(differences: FloatArray) -> FloatArray:
    """Return the two-sided p of each row's mean (rows,), exact to n = 16.

    Args:
        differences: paired differences (rows, n), n >= 1.

    Raises:
        ValueError: a difference is NaN, of which no p value would mean anything.
    """
    if np.isnan(differences).any():
        raise ValueError("A paired difference is NaN: leave incomplete pairs out.")
    signs = assignments(differences.shape[1])
    found = [_p_of(part, signs) for part in _parts(differences)]
    return np.concatenate(found) if found else np.zeros(0)


def _parts(rows: FloatArray) -> list[FloatArray]:
    """Split rows so that the statistics of all assignments fit into memory."""
    return [rows[start : start + _ROWS_AT_ONCE] for start in range(0, len(rows), _ROWS_AT_ONCE)]


def _p_of(rows: FloatArray, signs: FloatArray) -> FloatArray:
    null = np.abs(rows @ signs.T)
    return share_as_extreme(null, np.abs(rows.sum(axis=1)), _TIES * np.abs(rows).sum(axis=1), rows.shape[1])


def least_p(n: int) -> float:
    """Return the least p that n pairs can reach."""
    return 2.0 ** (1 - n) if n <= EXACT_UP_TO else max(2.0 ** (1 - n), 1 / (DRAWS + 1))


def fewest_pairs(level: float, most: int = 64) -> int | None:
    """Return the least n at which the test can reach p <= level; None when the draws are too few for it."""
    return next((n for n in range(1, most + 1) if least_p(n) <= level), None)
