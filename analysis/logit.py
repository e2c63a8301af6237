"""The conditional logit: what draws a choice among options that differ from choice to choice."""

from __future__ import annotations

import numpy as np

from analysis.arrays import BoolArray, FloatArray, IntArray

_ROUNDS = 50
_CLOSE = 1e-12
_STEEPEST = 20.0


def conditional_logit(options: FloatArray, offered: BoolArray, chosen: IntArray) -> FloatArray:
    """Return the log odds per unit of each covariate at the greatest likelihood, (c,), by Newton's method.

    P(option) is proportional to exp(beta . covariates) among those offered. NaN for a covariate that is the same for
    all options of every choice; NaN for all when the covariates cannot be told apart, or when they part the chosen from
    the others so well that there is no greatest likelihood. Source: McFadden 1974.

    Args:
        options: covariates of every option, (n, k, c); those not offered may hold anything finite.
        offered: whether the option was there, (n, k).
        chosen: index of the option taken, (n,).
    """
    beta = np.full(options.shape[2], np.nan)
    if not len(chosen):
        return beta
    centred = options - options[np.arange(len(chosen)), chosen][:, None]
    centred = np.where(offered[:, :, None], centred, 0.0)
    varies = np.any(centred != 0, axis=(0, 1))
    if varies.any():
        beta[varies] = _newton(centred[:, :, varies], offered)
    return beta


def _newton(relative: FloatArray, offered: BoolArray) -> FloatArray:
    """Return the fit; `relative` holds the covariates less those of the chosen option, (n, k, c)."""
    covariates = relative.shape[2]
    beta, failed = np.zeros(covariates), np.full(covariates, np.nan)
    for _ in range(_ROUNDS):
        weights = np.where(offered, np.exp(relative @ beta), 0.0)
        weights /= weights.sum(axis=1, keepdims=True)
        expected = (weights[:, :, None] * relative).sum(axis=1)
        weighted = (weights[:, :, None] * relative).reshape(-1, covariates)
        information = weighted.T @ relative.reshape(-1, covariates) - expected.T @ expected
        if np.linalg.matrix_rank(information, tol=1e-9) < covariates:
            return failed
        step = np.linalg.solve(information, -expected.sum(axis=0))
        beta = beta + step
        if np.abs(beta).max() > _STEEPEST:
            return failed
        if np.abs(step).max() < _CLOSE:
            return beta
    return failed
