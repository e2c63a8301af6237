"""Formulas shared by signatures; undefined values are NaN."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.arrays import BoolArray, FloatArray, IntArray


def ratio(part: float, whole: float) -> float:
    """Return part / whole; NaN if the whole is 0."""
    return part / whole if whole else math.nan


def mean(values: Iterable[float]) -> float:
    """Return the arithmetic mean, or NaN without values."""
    numbers = values.ravel().tolist() if isinstance(values, np.ndarray) else list(values)
    try:
        return ratio(math.fsum(numbers), len(numbers))
    except OverflowError:
        return math.fsum(number / len(numbers) for number in numbers)


def spread(values: FloatArray) -> float:
    """Return the standard deviation (ddof 1) of values (n,), without overflow; NaN below two values."""
    size = float(np.abs(values).max(initial=0))
    return size * float(np.std(values / (size or 1), ddof=1)) if len(values) > 1 else math.nan


def weighted_mean(values: NDArray[Any], weights: IntArray) -> float:
    """Return the mean of values (n,) with weights (n,), ignoring values of weight 0; NaN if all weights are 0."""
    weighty = weights > 0
    return ratio(float((values[weighty] * weights[weighty]).sum()), float(weights[weighty].sum()))


def weighted_variance(values: IntArray, weights: IntArray) -> float:
    """Return the variance (ddof 0) of values (n,) with weights (n,); NaN if all weights are 0."""
    return weighted_mean((values - weighted_mean(values, weights)) ** 2, weights)


def entropy(counts: ArrayLike) -> float:
    """Return Shannon's entropy of counts (k,), bits, 0..log2 k; NaN if all are 0."""
    p = np.asarray(counts, dtype=np.float64)
    total = float(p.sum())
    if not total:
        return math.nan
    shares = p[p > 0] / total
    return float(-(shares * np.log2(shares)).sum()) + 0.0


def variety(counts: ArrayLike) -> float:
    """Return the probability that two things drawn at random are of different kinds, 0..1; NaN below two things.

    Its expected value does not depend on the number of things. Source: Simpson 1949.

    Args:
        counts: number of things of each kind, whole numbers (k,).
    """
    amounts = np.asarray(counts, dtype=np.int64)
    total = int(amounts.sum())
    return 1 - ratio(float((amounts * (amounts - 1)).sum()), float(total * (total - 1)))


def normalised_entropy(counts: ArrayLike) -> float:
    """Return the entropy / its maximum log2 k, 0..1; NaN if all k counts are 0 or k < 2."""
    categories = np.asarray(counts).size
    return entropy(counts) / math.log2(categories) if categories > 1 else math.nan


def gini(values: ArrayLike) -> float:
    """Return the Gini coefficient of values (N,), 0..1 - 1/N; NaN if all are 0.

    With negative values, the denominator uses absolute values, which keeps the coefficient in this range. Source: Gini
    1912; Raffinetti, Siletti and Vernizzi 2015, times (N - 1) / N.
    """
    ranked = np.sort(np.asarray(values))
    ranks = np.arange(1, len(ranked) + 1)
    return ratio(float(((2 * ranks - len(ranked) - 1) * ranked).sum()), float(len(ranked) * np.abs(ranked).sum()))


def divergence(counts: ArrayLike, reference: ArrayLike) -> float:
    """Return the Kullback-Leibler divergence of counts (k,) from reference weights (k,), in bits; at least 0.

    NaN if all counts or all weights are 0; infinite if a count is positive where its weight is 0.
    """
    observed, expected = np.asarray(counts, dtype=np.float64), np.asarray(reference, dtype=np.float64)
    if not observed.sum() or not expected.sum():
        return math.nan
    occurring = observed > 0
    p, q = (observed / observed.sum())[occurring], (expected / expected.sum())[occurring]
    return max(0.0, float((p * np.log2(p / q)).sum())) if (q > 0).all() else math.inf


def jensen_shannon(first: ArrayLike, second: ArrayLike) -> float:
    """Return the Jensen-Shannon divergence of two rows of weights (k,), base 2, 0..1; NaN if a row has only zeros.

    This is the divergence; `scipy.spatial.distance.jensenshannon` returns its square root.
    """
    p, q = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if not p.sum() or not q.sum():
        return math.nan
    p, q = p / p.sum(), q / q.sum()
    return (divergence(p, p + q) + divergence(q, p + q)) / 2


def longest_run(flags: BoolArray) -> int:
    """Return the length of the longest unbroken sequence of True in flags (T,)."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int64), [0]))))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def survival(times: IntArray, observed: BoolArray) -> tuple[IntArray, FloatArray]:
    """Return the times of events, and for each the Kaplan-Meier estimate of the survival function S after this event.

    S is 1 before the first event, and constant between events. At the same time, events count before the ends of
    observations. Source: Kaplan and Meier 1958.

    Args:
        times: time until the event or the end of observation, steps, (n,).
        observed: whether the event occurred, (n,); otherwise the observation ended.
    """
    events: IntArray = np.unique(times[observed])
    at_risk = (times[:, None] >= events).sum(axis=0)
    ended = (observed[:, None] & (times[:, None] == events)).sum(axis=0)
    remaining: FloatArray = np.multiply.accumulate(1 - ended / np.maximum(at_risk, 1))
    return events, remaining


def restricted_mean(times: IntArray, observed: BoolArray, horizon: int) -> float:
    """Return the restricted mean survival time, which is the area under S from 0 to the horizon; NaN without times.

    The mean is between 0 and the horizon, in the unit of the times. A low value means that events come soon. After the
    last event, S stays constant.
    """
    if not len(times):
        return float("nan")
    events, remaining = survival(times, observed)
    edges = np.minimum(np.concatenate(([0], events, [horizon])), horizon)
    return float((np.diff(edges) * np.concatenate(([1.0], remaining))).sum())
