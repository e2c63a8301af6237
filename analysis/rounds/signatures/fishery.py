"""Fishery: how long a common stock lasts, and how much each agent catches."""

import numpy as np

from analysis.formulas import gini, mean, ratio
from analysis.measure import HIGH, LOW, Measure, outcome, share
from analysis.rounds.rounds_run import RoundsRun

NAME = "fishery"
CATCH, STOCK = "catch", "stock"
KEYS = {"before", "caught", "after", "next"}

MEASURES = {
    "months": Measure("Months with fishing", 1, better=HIGH, says="fishes for {more|fewer} months"),
    "survived": outcome("Fished in every month (1) or collapsed earlier (0)", better=HIGH),
    "gain": Measure("Tons caught in total (mean of agents)", 0, better=HIGH),
    "efficiency": share("Tons caught, of the sustainable maximum", better=HIGH),
    "equality": share("Equality of the agents' catches (1 - Gini)", better=HIGH),
    "over_use": share("Catches beyond the sustainable share", better=LOW, says="over-fishes {more|less}"),
}

HEADLINE = ("months", "efficiency", "equality", "over_use")


def applies(run: RoundsRun) -> bool:
    """Return whether the world has a stock that agents fish: it declares catches and the file of the stock."""
    return CATCH in run.declared.actions and run.declared.streams.get(STOCK, {}).keys() >= KEYS


def measure(run: RoundsRun) -> dict[str, float]:
    """Return for how many months the stock lasts, and how much each agent catches.

    A catch is the amount received, which may be less than the amount wanted. The catches of an outsider are left out.

    - months: number of months with fishing; 1 if the stock collapses with the first catch.
    - survived: 1 if there was fishing in all months of the world, else 0. The stock after the last month does not
      matter.
    - gain: mean over agents of the tons caught in the whole run.
    - efficiency: min(1, tons caught by all / (N x months of the world x f)), f the sustainable share of the full stock.
      NaN if f is 0 tons.
    - equality: 1 - Gini coefficient over agents of the tons caught in the whole run. NaN without any catch.
    - over_use: share of the counted catches above floor(floor(stock / 2) / N), the sustainable share of that month.

    NaN without counted catches. Denominators: n_agents, n_catches (counted). Source: Piatti et al. 2024 (arXiv
    2404.16698).
    """
    asked = run.kind == CATCH
    counted = asked & run.counted
    if not counted.any():
        return dict.fromkeys(MEASURES, np.nan) | {"n_agents": float(run.agents), "n_catches": 0.0}
    months = run.streams[STOCK]
    gains = np.bincount(run.agent[asked], weights=run.utility[asked], minlength=run.agents)
    sustainable = np.array([month["before"] // 2 // run.agents for month in months])
    most = run.agents * run.world["steps"] * (run.world["stock"] // 2 // run.agents)
    return {
        "months": float(len(months)),
        "survived": float(len(months) == run.world["steps"]),
        "gain": mean(gains),
        "efficiency": float(np.minimum(1.0, ratio(float(gains.sum()), most))),
        "equality": 1 - gini(gains),
        "over_use": mean(run.utility[counted] > sustainable[run.step[counted] - 1]),
        "n_agents": float(run.agents),
        "n_catches": float(counted.sum()),
    }
