"""Utility: the payoffs of agents in a run, and how equally they are distributed."""

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.any.decided import numbers
from analysis.any.deviations import ALIKE, lasting
from analysis.arrays import FloatArray
from analysis.formulas import gini, mean, spread
from analysis.measure import Measure, Null, share

NAME = "utility"

MEASURES = {
    "mean": Measure("Utility per decision (mean of agents)", says="reaches {more|less} utility"),
    "spread": Measure("Spread of utility over agents (standard deviation)", low=0),
    "gini": share("Inequality of utility (Gini)", says="distributes utility {less|more} evenly"),
    "beyond_shuffled": Measure(
        "Lasting differences of utility between agents, minus those of shuffled agents (share)", null=Null(0, ALIKE)
    ),
}

HEADLINE = ("mean", "gini", "beyond_shuffled")


def measure(run: AnyRun) -> dict[str, float]:
    """Return the utility of a run over the counted decisions with a utility; empty if the world declares none.

    An agent's utility is the mean over its decisions, so agents gain nothing by deciding more often.

    - mean: mean over agents, in the world's unit.
    - spread: standard deviation over agents (ddof 1), in the world's unit. NaN below two agents.
    - gini: Gini coefficient over agents: the sum over pairs of the absolute difference, divided by N times the sum of
      the absolute values; 0..1 - 1/N. Absolute values keep it within these bounds even with losses; without losses it
      is the usual coefficient. Agents with equal behaviour do not give 0, because luck spreads their utilities, though
      less in longer runs. Adding a constant to all utilities changes it. NaN if all utilities are 0.
    - beyond_shuffled: lasting differences of utility between agents, as in `heterogeneity`; luck alone gives 0.

    NaN without utilities. Denominators: n_agents (with a utility), n_decisions (with a utility).
    """
    if "utility" not in run.declared.streams.get("steps", {}):
        return {}
    has_one = run.counted & ~np.isnan(run.utility)
    agent, number = run.agent[has_one], np.bincount(run.agent[has_one], minlength=run.agents)
    parts = run.utility[has_one] / number[agent]  # divided before the sum, which could overflow
    by_agent: FloatArray = np.bincount(agent, weights=parts, minlength=run.agents)[number > 0].astype(np.float64)
    by_kind = [numbers(run, kind, run.kind == kind, run.utility) for kind in sorted(set(run.kind.tolist()))]
    return {
        "mean": mean(by_agent),
        "spread": spread(by_agent),
        "gini": gini(by_agent / (np.abs(by_agent).max(initial=0) or 1)),
        "beyond_shuffled": lasting(by_kind, run.agents).share,
        "n_agents": float(len(by_agent)),
        "n_decisions": float(has_one.sum()),
    }
