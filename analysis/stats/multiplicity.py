"""Many tests at once."""

from __future__ import annotations

import numpy as np

from analysis.arrays import FloatArray


def holm(p: FloatArray) -> FloatArray:
    """Return p values adjusted by Holm's step-down method (n,); NaN are no tests and stay (Holm 1979)."""
    adjusted = np.full(len(p), np.nan)
    tests = np.flatnonzero(~np.isnan(p))
    order = tests[np.argsort(p[tests], kind="stable")]
    factors = np.arange(len(order), 0, -1)
    adjusted[order] = np.minimum(np.maximum.accumulate(p[order] * factors), 1.0) if len(order) else []
    return adjusted


def benjamini_hochberg(p: FloatArray) -> FloatArray:
    """Return p values adjusted to bound the false discovery rate (n,); NaN stay (Benjamini, Hochberg 1995)."""
    adjusted = np.full(len(p), np.nan)
    tests = np.flatnonzero(~np.isnan(p))
    order = tests[np.argsort(p[tests], kind="stable")[::-1]]
    factors = len(order) / np.arange(len(order), 0, -1)
    adjusted[order] = np.minimum(np.minimum.accumulate(p[order] * factors), 1.0) if len(order) else []
    return adjusted
