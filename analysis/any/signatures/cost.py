"""Cost: the calls, tokens and time of a run."""

import math

from analysis.any.any_run import AnyRun
from analysis.costs import RunCost
from analysis.formulas import ratio
from analysis.measure import Measure, share

NAME = "cost"

READABLE_TOO = False

MEASURES = {
    "calls": Measure("Model calls", low=0),
    "cached": Measure("Calls answered from the cache", low=0),
    "retries": Measure("Tries that failed", low=0),
    "prompt_tokens": Measure("Tokens of the prompts", low=0),
    "output_tokens": Measure("Tokens of the replies", low=0),
    "model_s": Measure("Seconds of the model", low=0),
    "wall_s": Measure("Seconds from start to end", low=0),
    "cached_share": share("Calls answered from the cache (share)"),
    "prompt_cached_share": share("Tokens of the prompts from the server's prompt cache (share)"),
    "calls_per_decision": Measure("Model calls per decision", low=0),
    "retries_per_decision": Measure("Tries that failed, per decision", low=0),
    "prompt_tokens_per_decision": Measure("Tokens of the prompts per decision", low=0),
    "output_tokens_per_decision": Measure("Tokens of the replies per decision", low=0),
    "model_s_per_decision": Measure("Seconds of the model per decision", low=0),
    "wall_s_per_decision": Measure("Seconds from start to end, per decision", low=0),
}

HEADLINE = ("prompt_tokens_per_decision", "output_tokens_per_decision", "model_s_per_decision", "retries")


def measure(run: AnyRun) -> dict[str, float]:
    """Return the cost of a run from its `run.json`; a decision is a line of its steps.

    - calls: model calls. cached: calls answered from the cache of answers. retries: failed tries before an answer.
    - prompt_tokens, output_tokens: tokens counted by the server, including cached answers.
    - model_s: seconds from call to answer, summed over calls. A cached call counts with its original time; parallel
      calls each count in full. NaN where it was not recorded.
    - wall_s: seconds from the run's start to its end. Cached answers make it short; runs played in parallel make it
      long.
    - cached_share: cached calls / calls; 0..1. NaN without calls.
    - prompt_cached_share: prompt tokens that the server read from its prompt cache / prompt tokens; 0..1. NaN if the
      server does not report it, as Ollama.
    - <name>_per_decision: the measure / decisions. NaN without decisions.

    All measures are 0 or above, and NaN if the run does not record them. Denominator: n_decisions.
    """
    return cost_measures(run.cost, run.decisions)


def cost_measures(cost: RunCost | None, decisions: int) -> dict[str, float]:
    """Return the total cost and the cost per decision; NaN where unknown."""
    if cost is None:
        return {**dict.fromkeys(MEASURES, math.nan), "n_decisions": float(decisions)}
    totals = {
        "calls": cost.calls,
        "retries": cost.retries,
        "prompt_tokens": cost.prompt_tokens,
        "output_tokens": cost.output_tokens,
        "model_s": cost.model_s,
        "wall_s": cost.wall_s,
    }
    return {
        **{name: float(value) for name, value in totals.items()},
        "cached": float(cost.cached),
        "cached_share": ratio(cost.cached, cost.calls),
        "prompt_cached_share": ratio(cost.cached_tokens, cost.prompt_tokens),
        **{f"{name}_per_decision": ratio(value, decisions) for name, value in totals.items()},
        "n_decisions": float(decisions),
    }
