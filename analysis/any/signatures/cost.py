"""Cost: the calls, tokens and time of a run."""

import math

from analysis.any.any_run import AnyRun
from analysis.formulas import ratio
from analysis.measure import Measure, share
from foundry.records import Counts

NAME = "cost"

READABLE_TOO = False

MEASURES = {
    "calls": Measure("Model calls", low=0),
    "cached": Measure("Calls answered from the cache", low=0),
    "retries": Measure("Tries that failed", low=0),
    "prompt_tokens": Measure("Tokens of the prompts", low=0),
    "output_tokens": Measure("Tokens of the replies", low=0),
    "model_s": Measure("Seconds until the model's answers, summed over calls", low=0),
    "wall_s": Measure("Seconds from the run's start to its end", low=0),
    "cached_share": share("Calls answered from the cache (share)"),
    "prompt_cached_share": share("Tokens of the prompts from the server's prompt cache (share)"),
    "calls_per_decision": Measure("Model calls per decision", low=0),
    "retries_per_decision": Measure("Tries that failed, per decision", low=0),
    "prompt_tokens_per_decision": Measure("Tokens of the prompts per decision", low=0),
    "output_tokens_per_decision": Measure("Tokens of the replies per decision", low=0),
    "model_s_per_decision": Measure("Seconds until the model's answers, per decision", low=0),
    "wall_s_per_decision": Measure("Seconds from the run's start to its end, per decision", low=0),
}

HEADLINE = ("prompt_tokens_per_decision", "output_tokens_per_decision", "model_s_per_decision", "retries")


def measure(run: AnyRun) -> dict[str, float]:
    """Return the cost of a run from its `run.json`; each line in the run's record of steps counts as one decision.

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
    unknown = dict.fromkeys(MEASURES, math.nan)
    measures = unknown if run.totals is None else _costs(run.totals, run.wall_s, run.decisions)
    return {**measures, "n_decisions": float(run.decisions)}


def _costs(counts: Counts, wall_s: float, decisions: int) -> dict[str, float]:
    totals = {name: float(getattr(counts, name)) for name in ("calls", "retries", "prompt_tokens", "output_tokens")}
    totals |= {"model_s": math.nan if counts.model_s is None else counts.model_s, "wall_s": wall_s}
    cached_tokens = math.nan if counts.cached_tokens is None else counts.cached_tokens
    return {
        **totals,
        "cached": float(counts.cached),
        "cached_share": ratio(counts.cached, counts.calls),
        "prompt_cached_share": ratio(cached_tokens, counts.prompt_tokens),
        **{f"{name}_per_decision": ratio(value, decisions) for name, value in totals.items()},
    }
