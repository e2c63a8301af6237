"""Which test each row of pairs has, and its p."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from analysis.arrays import FloatArray
from analysis.stats.intervals import FEWEST_FOR_CLAIMS, NO_VARIATION, by_count, varies
from analysis.stats.paired import mcnemar_p
from analysis.stats.pairing import Paired
from analysis.stats.sign_flip import sign_flip_p

SIGN_FLIP, MCNEMAR = "sign-flip", "mcnemar"
NOT_TESTED = "not tested: "
_NO_PAIR = NOT_TESTED + "no pair"
_FEW_PAIRS = f"{NOT_TESTED}n < {FEWEST_FOR_CLAIMS}"
_FLAT = NOT_TESTED + NO_VARIATION


def tested(paired: Paired) -> tuple[npt.NDArray[np.object_], FloatArray]:
    """Return the test of each row, or why there is none (R,), and its two-sided p (R,), NaN where there is none."""
    test = np.full(len(paired.pair), _NO_PAIR, dtype=object)
    p = np.full(len(test), np.nan)
    for rows, kept in by_count(paired.difference):
        test[rows] = _FEW_PAIRS
        if _are_enough(kept.shape[1]):
            # Success of one against failure of the other in every seed varies no more than equal outcomes do.
            mcnemar = paired.outcome[rows] & kept.any(axis=1)
            test[rows] = np.where(mcnemar, MCNEMAR, np.where(varies(kept), SIGN_FLIP, _FLAT))
            for name, p_of in ((MCNEMAR, mcnemar_p), (SIGN_FLIP, sign_flip_p)):
                own = test[rows] == name
                p[rows[own]] = p_of(kept[own])
    return test, p


def p_of_row(p_of: Callable[[FloatArray], FloatArray], values: FloatArray) -> float:
    """Return p of the values of a single row (n,) by a test of rows (rows, n); NaN where they are too few for one."""
    return float(p_of(values[None, :])[0]) if _are_enough(len(values)) else np.nan


def _are_enough(n: int) -> bool:
    """Return whether so many values are tested: fewer describe these runs, and count in no family."""
    return n >= FEWEST_FOR_CLAIMS
