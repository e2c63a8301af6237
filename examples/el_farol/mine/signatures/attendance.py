"""Attendance: how near the bar comes to its capacity, and how many go."""

from __future__ import annotations

import numpy as np

from analysis.measure import Measure, Null, share
from analysis.rounds.run import RoundsRun

NAME = "attendance"
CAPACITY = 0.6

MEASURES = {
    "score": Measure("Nearness to the capacity (0 to 100)", 0, 100, Null(75.4, "ten agents that toss coins")),
    "share": share("Mean share that goes"),
    "volatility": Measure("Variance of the attendance, of that of coins", 0, null=Null(1, "agents that toss coins")),
}
HEADLINE = ("score", "volatility")


def measure(run: RoundsRun) -> dict[str, float]:
    """Return the measures over the evenings on which anyone's decision counts.

    - score: 100 (R - S) / R with S the mean distance of the share that goes from the capacity, and R the greatest one.
    - share: mean share that goes.
    - volatility: variance of the number that goes over the evenings / (N / 4), which it is for coins.

    Denominator: n_evenings.
    """
    went = run.shares("evening")["go"]
    went = went[~np.isnan(went)]
    distance = np.abs(went - CAPACITY).mean() if went.size else np.nan
    return {
        "score": float(100 * (1 - distance / max(CAPACITY, 1 - CAPACITY))),
        "share": float(went.mean()) if went.size else np.nan,
        "volatility": float(went.var() * run.agents * 4) if went.size > 1 else np.nan,
        "n_evenings": float(went.size),
    }
