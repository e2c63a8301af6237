"""Tests the difference of each row, and corrects the p values of several tests."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from analysis.arrays import FloatArray
from analysis.stats.factors import Pair
from analysis.stats.intervals import FEWEST_FOR_CLAIMS, SIGN_FLIP, by_count
from analysis.stats.max_t import over_pairs, step_down_p
from analysis.stats.pairing import Paired
from analysis.stats.sign_flip import sign_flip_p


def holm(p: FloatArray) -> FloatArray:
    """Correct p values (n,) by Holm's step-down method (Holm 1979); NaN, for a row without test, stays NaN."""
    return over_pairs(p, np.arange(len(p)))


def benjamini_hochberg(p: FloatArray) -> FloatArray:
    """Adjust p values (n,) so that they bound the false discovery rate (Benjamini, Hochberg 1995); NaN stays NaN."""
    adjusted = np.full(len(p), np.nan)
    tests = np.flatnonzero(~np.isnan(p))
    order = tests[np.argsort(p[tests], kind="stable")[::-1]]
    factors = len(order) / np.arange(len(order), 0, -1)
    adjusted[order] = np.minimum(np.minimum.accumulate(p[order] * factors), 1.0) if len(order) else []
    return adjusted


NOT_TESTED = "not tested: "
_NO_PAIR = NOT_TESTED + "no pair"
_FEW_PAIRS = f"{NOT_TESTED}n < {FEWEST_FOR_CLAIMS}"
_EQUAL = NOT_TESTED + "no difference in any seed"
_ROUNDING = 1e-12


def tested(paired: Paired) -> tuple[npt.NDArray[np.object_], FloatArray]:
    """Return the test of each row, or the reason why there is none (R,), and its two-sided p or NaN (R,)."""
    test = np.full(len(paired.pair), _NO_PAIR, dtype=object)
    p = np.full(len(test), np.nan)
    for rows, differences in by_count(paired.difference):
        test[rows] = _FEW_PAIRS
        if differences.shape[1] >= FEWEST_FOR_CLAIMS:
            size = np.fmax(np.abs(paired.level[rows]), np.abs(paired.reference[rows]))
            differ = (np.abs(differences) > _ROUNDING * np.fmax(np.nanmax(size, axis=1), 1.0)[:, None]).any(axis=1)
            test[rows] = np.where(differ, SIGN_FLIP, _EQUAL)
            p[rows[differ]] = sign_flip_p(differences[differ])
    return test, p


def corrected_in_pairs(paired: Paired, p: FloatArray) -> FloatArray:
    """Correct the p value of each row, (R,), for the number of tests of its pair of groups; NaN stays NaN."""
    corrected = np.full(len(p), np.nan)
    rows_by_pair: dict[Pair, list[int]] = {}
    for row in np.flatnonzero(~np.isnan(p)).tolist():
        rows_by_pair.setdefault(paired.pair[row], []).append(row)
    differences = paired.difference
    for rows in rows_by_pair.values():
        own = differences[rows]
        # Drawn signs may give a p below the p of the row alone, which draws its signs for fewer seeds.
        corrected[rows] = np.maximum(step_down_p(own[:, ~np.isnan(own).all(axis=0)]), p[rows])
    return corrected


def p_of_row(p_of: Callable[[FloatArray], FloatArray], values: FloatArray) -> float:
    """Return the p value of one row of values (n,), from a test `p_of` that takes several rows (rows, n).

    NaN if there are too few values for a test.
    """
    return float(p_of(values[None, :])[0]) if len(values) >= FEWEST_FOR_CLAIMS else np.nan
