"""Utility: the payoffs of agents in a run, and how equal they are."""

from collections.abc import Iterator

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.any.decided import Decided, numbers
from analysis.any.deviations import ALIKE, lasting
from analysis.arrays import FloatArray
from analysis.formulas import gini, mean, spread
from analysis.measure import Measure, Null, share

NAME = "utility"

MEASURES = {
    "mean": Measure("Utility per decision (mean of agents)", says="reaches {more|less} utility"),
    "spread": Measure("Spread of utility over agents (standard deviation)", low=0),
    "gini": share("Inequality of utility (Gini)", says="shares utility out {less|more} evenly"),
    "beyond_shuffled": Measure("Lasting differences of utility, beyond shuffled agents (share)", null=Null(0, ALIKE)),
}

HEADLINE = ("mean", "gini", "beyond_shuffled")


def measure(run: AnyRun) -> dict[str, float]:
    """Return the utility of a run, over the counted decisions with one; nothing where the world declares no such key.

    An agent's utility is the mean over its decisions, so that who decides more often does not have more for that.

    - mean: mean over agents, in the world's unit.
    - spread: standard deviation over agents (ddof 1), in the world's unit. NaN below two agents.
    - gini: Gini coefficient over agents, sum over pairs of the difference / (N times the sum of the sizes); 0..1 - 1/N.
      Sizes are taken without their sign, so that losses keep it within these bounds; where there are none it is the
      usual one. It is not 0 for agents that are alike: luck spreads them, the less the longer the run. Adding the
      same to everybody's utility changes it. NaN when all are 0.
    - beyond_shuffled: differences of utility between agents that last, as in `heterogeneity`: 0 for what luck does.

    NaN without utilities. Denominators: n_agents (with one), n_decisions (with one).
    """
    if "utility" not in run.declared.streams.get("steps", {}):
        return {}
    has_one = run.counted & ~np.isnan(run.utility)
    by_agent = _means(run)
    return {
        "mean": mean(by_agent),
        "spread": spread(by_agent),
        "gini": gini(by_agent / (np.abs(by_agent).max(initial=0) or 1)),
        "beyond_shuffled": lasting(list(_by_kind(run)), run.agents).share,
        "n_agents": float(len(by_agent)),
        "n_decisions": float(has_one.sum()),
    }


def _means(run: AnyRun) -> FloatArray:
    """Return the mean utility of each agent with any, (agents with one,)."""
    has_one = run.counted & ~np.isnan(run.utility)
    number = np.bincount(run.agent[has_one], minlength=run.agents)
    parts = run.utility[has_one] / number[run.agent[has_one]]
    return np.asarray(np.bincount(run.agent[has_one], weights=parts, minlength=run.agents)[number > 0])


def _by_kind(run: AnyRun) -> Iterator[Decided]:
    for kind in sorted(set(run.kind.tolist())):
        yield numbers(run, kind, (run.kind == kind) & ~np.isnan(run.utility), run.utility)
