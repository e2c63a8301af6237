"""Which test each row of pairs has, and its p."""

from __future__ import annotations

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
        if kept.shape[1] >= FEWEST_FOR_CLAIMS:
            # Success of one against failure of the other in every seed varies no more than equal outcomes do.
            mcnemar = paired.outcome[rows] & kept.any(axis=1)
            test[rows] = np.where(mcnemar, MCNEMAR, np.where(varies(kept), SIGN_FLIP, _FLAT))
            for name, p_of in ((MCNEMAR, mcnemar_p), (SIGN_FLIP, sign_flip_p)):
                own = test[rows] == name
                p[rows[own]] = p_of(kept[own])
    return test, p
