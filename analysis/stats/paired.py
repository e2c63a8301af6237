"""Statistics of paired differences; rows of pairs without NaN, (rows, n)."""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import FloatArray
from analysis.stats.values import BoolArray

_TIE = 1e-12


def superiority(differences: FloatArray) -> FloatArray:
    """Return P(first > second within a pair) of each row (rows,), ties half."""
    tie = _TIE * np.maximum(np.abs(differences).max(axis=1, keepdims=True), 1.0)
    greater, equal = (differences > tie).mean(axis=1), (np.abs(differences) <= tie).mean(axis=1)
    return np.asarray(greater + 0.5 * equal, dtype=np.float64)


def hedges_g_z(mean: FloatArray, sd: FloatArray, n: int) -> FloatArray:
    """Return J(n - 1) mean / sd of paired differences (rows,), J Hedges' exact correction; NaN where sd is 0."""
    if n < 2:
        return np.full(len(mean), np.nan)
    return hedges_correction(n - 1) * mean / np.where(sd > 0, sd, np.nan)


def hedges_correction(freedom: int) -> float:
    """Return J = Gamma(f/2) / (sqrt(f/2) Gamma((f-1)/2)), by which d overstates (Hedges 1981); 0 for f = 1."""
    if freedom < 2:
        return 0.0
    return math.exp(math.lgamma(freedom / 2) - math.lgamma((freedom - 1) / 2)) / math.sqrt(freedom / 2)


def are_outcomes(values: FloatArray) -> BoolArray:
    """Return which measures take the values 0 and 1, both and no other (M,); values (..., M), NaN left out."""
    flat = values.reshape(-1, values.shape[-1])
    zeros, ones = (flat == 0), (flat == 1)
    nothing_else = (zeros | ones | np.isnan(flat)).all(axis=0)
    return np.asarray(zeros.any(axis=0) & ones.any(axis=0) & nothing_else)
