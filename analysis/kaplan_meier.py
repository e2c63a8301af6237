"""How long something takes when not everything is seen to its end: the Kaplan-Meier estimate."""

from __future__ import annotations

import numpy as np

from analysis.arrays import BoolArray, FloatArray, IntArray


def survival(times: IntArray, observed: BoolArray) -> tuple[IntArray, FloatArray]:
    """Return the event times and the Kaplan-Meier estimate of S from each on; events precede censorings at ties.

    Before the first event S is 1, between events it is level. Source: Kaplan and Meier 1958.

    Args:
        times: how long each was watched, steps, (n,).
        observed: whether the event came then; else the watching ended, (n,).
    """
    events: IntArray = np.unique(times[observed])
    at_risk = (times[:, None] >= events).sum(axis=0)
    ended = (observed[:, None] & (times[:, None] == events)).sum(axis=0)
    remaining: FloatArray = np.multiply.accumulate(1 - ended / np.maximum(at_risk, 1))
    return events, remaining


def restricted_mean(times: IntArray, observed: BoolArray, horizon: int) -> float:
    """Return the restricted mean survival time, the area under S from 0 to the horizon; NaN of nothing.

    Low is fast; between 0 and the horizon, in its unit. Behind the last event S stays level.
    """
    if not len(times):
        return float("nan")
    events, remaining = survival(times, observed)
    edges = np.minimum(np.concatenate(([0], events, [horizon])), horizon)
    return float((np.diff(edges) * np.concatenate(([1.0], remaining))).sum())
