"""The cost of a run: calls, tokens and time."""

import math
from dataclasses import dataclass

from foundry.records import RunSummary


@dataclass(frozen=True)
class RunCost:
    """The cost of a run.

    Attributes:
        calls: model calls.
        cached: calls answered from the cache of answers.
        retries: failed tries before an answer.
        prompt_tokens: tokens sent, cached answers included.
        output_tokens: tokens received, cached answers included.
        cached_tokens: prompt tokens that servers read from their prompt caches; NaN if no server reports it.
        model_s: seconds of all answers; cached answers count with their original time. NaN where unknown.
        wall_s: seconds from the run's start to its end.
    """

    calls: int
    cached: int
    retries: int
    prompt_tokens: int
    output_tokens: int
    cached_tokens: float
    model_s: float
    wall_s: float


def cost_of(summary: RunSummary | None) -> RunCost | None:
    """Return the cost of a run; None if it has not ended."""
    if summary is None:
        return None
    counts = summary.counts
    return RunCost(
        calls=counts.calls,
        cached=counts.cached,
        retries=counts.retries,
        prompt_tokens=counts.prompt_tokens,
        output_tokens=counts.output_tokens,
        cached_tokens=math.nan if counts.cached_tokens is None else counts.cached_tokens,
        model_s=math.nan if counts.model_s is None else counts.model_s,
        wall_s=summary.duration_s,
    )
