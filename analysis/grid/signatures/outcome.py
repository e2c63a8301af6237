"""Outcome: how many of a model's replies could be used.

Show it beside every other signature: a reply that cannot be read leaves the agent in place and silent, which
raises idle rate, persistence and clustering and lowers exploration and communication.
"""

from __future__ import annotations

from analysis.arrays import OUTCOMES, READABLE, IntArray
from analysis.formulas import ratio
from analysis.grid.run import GridRun
from analysis.measure import share

NAME = "outcome"

READABLE_TOO = False

MEASURES = {
    "readable": share("Readable action replies (share)"),
    "failure_rate": share("Action replies without a decision (share)"),
    "message_readable": share("Readable message replies (share)"),
    "message_failure_rate": share("Message replies without a decision (share)"),
    **{str(outcome): share(f"Action replies: {outcome} (share)") for outcome in OUTCOMES},
    **{f"message_{outcome}": share(f"Message replies: {outcome} (share)") for outcome in OUTCOMES},
}

HEADLINE = ("readable", "message_readable", "repaired")


def measure(run: GridRun) -> dict[str, float]:
    """Return the outcomes of a run's calls.

    - <outcome>: action calls with this outcome / action calls; 0..1. The six shares add up to 1.
    - message_<outcome>: the same for the message calls.
    - readable, message_readable: share of `chosen` and `repaired` together; 0..1.
    - failure_rate, message_failure_rate: share of the other four, decisions that could not be read; 0..1.

    Denominators: n_decisions and n_message_decisions, calls of each kind.
    """
    actions, messages = outcome_shares(run.outcome), outcome_shares(run.message_outcome)
    return {
        **actions,
        **{f"message_{name}": value for name, value in messages.items()},
        "n_decisions": float(run.outcome.size),
        "n_message_decisions": float(run.message_outcome.size),
    }


def outcome_shares(outcomes: IntArray) -> dict[str, float]:
    """Return the share of each outcome and of the readable ones; outcomes of any shape, indices of OUTCOMES."""
    counts = {name: int((outcomes == index).sum()) for index, name in enumerate(OUTCOMES)}
    readable = sum(counts[OUTCOMES[index]] for index in READABLE)
    shares = {str(name): ratio(count, outcomes.size) for name, count in counts.items()}
    return {
        "readable": ratio(readable, outcomes.size),
        "failure_rate": ratio(outcomes.size - readable, outcomes.size),
        **shares,
    }
