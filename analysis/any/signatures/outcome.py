"""Outcome: the share of a model's replies that were readable.

Read this signature with every other one: after an unreadable reply the world chooses the agent's action.
"""

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.arrays import OUTCOMES, READABLE, IntArray
from analysis.formulas import ratio
from analysis.measure import HIGH, LOW, share

NAME = "outcome"

READABLE_TOO = False

MEASURES = {
    "readable": share("Readable action replies (share)", better=HIGH, says="gives readable replies {more|less} often"),
    "failure_rate": share("Action replies without a decision (share)", better=LOW),
    "message_readable": share("Readable message replies (share)", better=HIGH),
    "message_failure_rate": share("Message replies without a decision (share)", better=LOW),
    **{str(outcome): share(f"Action replies: {outcome} (share)") for outcome in OUTCOMES},
    **{f"message_{outcome}": share(f"Message replies: {outcome} (share)") for outcome in OUTCOMES},
}

HEADLINE = ("readable", "message_readable", "repaired")


def measure(run: AnyRun) -> dict[str, float]:
    """Return the share of each outcome among a run's calls.

    Action calls are the calls of kinds for which the world declares actions, or all calls if it declares none. All
    other calls are message calls, which are measured only if agents can send messages.

    - <outcome>: action calls with this outcome / action calls; 0..1. The six shares add up to 1.
    - message_<outcome>: message calls with this outcome / message calls; 0..1.
    - readable, message_readable: share of `chosen` and `repaired` together; 0..1.
    - failure_rate, message_failure_rate: share of the other four outcomes, unreadable decisions; 0..1.

    NaN without such calls. Denominators: n_decisions (action calls), n_message_decisions (message calls).
    """
    acting = np.isin(run.kind, list(run.declared.actions or set(run.kind.tolist())))
    measures = {**outcome_shares(run.outcome[acting]), "n_decisions": float(acting.sum())}
    if run.talks:
        messages = outcome_shares(run.outcome[~acting])
        measures |= {f"message_{name}": value for name, value in messages.items()}
        measures["n_message_decisions"] = float((~acting).sum())
    return measures


def outcome_shares(outcomes: IntArray) -> dict[str, float]:
    """Return the share of replies with each outcome, and of readable replies; `outcomes` are indices into OUTCOMES."""
    counts = {name: int((outcomes == index).sum()) for index, name in enumerate(OUTCOMES)}
    readable = sum(counts[OUTCOMES[index]] for index in READABLE)
    shares = {str(name): ratio(count, outcomes.size) for name, count in counts.items()}
    return {
        "readable": ratio(readable, outcomes.size),
        "failure_rate": ratio(outcomes.size - readable, outcomes.size),
        **shares,
    }
