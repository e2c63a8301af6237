"""Attendance: how near the bar comes to its capacity, and how many go."""

import numpy as np

from foundry import Measure, Null, RoundsRun, share

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
    - volatility: unbiased variance of the number that goes over the evenings / (N / 4), which it is for coins.

    Denominator: n_evenings.
    """
    went = np.array([share for share in run.shares("evening")["go"] if not np.isnan(share)])
    if not went.size:
        return dict.fromkeys(MEASURES, np.nan) | {"n_evenings": 0.0}
    distance = np.abs(went - CAPACITY).mean() / max(CAPACITY, 1 - CAPACITY)
    variance = went.var(ddof=1) if went.size > 1 else np.nan
    found = {"score": 100 * (1 - distance), "share": went.mean(), "volatility": variance * run.agents * 4}
    return {name: float(value) for name, value in found.items()} | {"n_evenings": float(went.size)}
