"""Computes the uncertainty that random labels in copies of a run add to a difference; see `labelling.correcting`."""

import numpy as np

from analysis.arrays import FloatArray


def variance_of_copies(differences: FloatArray) -> float:
    """Return what the variance of the mean difference over seeds gains because m copies of each run differ.

    Each copy has a mean difference. W is the mean of the variances of these means, and B is the variance of these means
    between copies. V is the variance of the mean of the differences that were first averaged over copies. The result is
    W + (1 + 1/m) B - V, but at least 0. Together with V, it is Rubin's total variance.

    Args:
        differences: differences of pairs by seed and copy, (S, m); NaN where a difference is undefined in a copy.

    Source: Rubin 1987, chapter 3.
    """
    defined = differences[~np.isnan(differences).all(axis=1)]
    seeds, copies = defined.shape
    if seeds < 2:
        return 0.0
    # A copy in which a seed is undefined gets the mean of the other copies.
    filled = np.where(np.isnan(defined), np.nanmean(defined, axis=1, keepdims=True), defined)
    within = float(filled.var(axis=0, ddof=1).mean()) / seeds
    between = float(filled.mean(axis=0).var(ddof=1))
    averaged = float(filled.mean(axis=1).var(ddof=1)) / seeds
    return float(max(0.0, within + (1 + 1 / copies) * between - averaged))


def widened(differences: FloatArray, added: FloatArray) -> FloatArray:
    """Spread differences (R, S) around the mean of their row, so that the variance of this mean grows by `added` (R,).

    Then every test and interval over seeds includes the uncertainty of the copies.
    """
    rows = np.flatnonzero(added > 0)
    wide = differences.copy()
    for row in rows:
        own = differences[row][~np.isnan(differences[row])]
        variance = float(own.var(ddof=1)) / len(own) if len(own) > 1 else 0.0
        if variance > 0:
            wide[row] = own.mean() + (differences[row] - own.mean()) * np.sqrt(1 + added[row] / variance)
    return wide
