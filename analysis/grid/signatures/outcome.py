"""Outcome: the share of a model's replies that were readable.

Read this signature with every other one. After an unreadable reply, the agent stays in place and is silent. Unreadable
replies therefore raise the idle rate, persistence and clustering, and lower exploration and communication.
"""

from analysis.any.signatures.outcome import HEADLINE, MEASURES, NAME, READABLE_TOO, outcome_shares
from analysis.grid.grid_run import GridRun

__all__ = ["HEADLINE", "MEASURES", "NAME", "READABLE_TOO", "measure"]


def measure(run: GridRun) -> dict[str, float]:
    """Return the share of each outcome among a run's calls.

    - <outcome>: action calls with this outcome / action calls; 0..1. The six shares add up to 1.
    - message_<outcome>: message calls with this outcome / message calls; 0..1.
    - readable, message_readable: share of `chosen` and `repaired` together; 0..1.
    - failure_rate, message_failure_rate: share of the other four outcomes, unreadable decisions; 0..1.

    Denominators: n_decisions (action calls), n_message_decisions (message calls).
    """
    actions, messages = (outcome_shares(each[run.there]) for each in (run.outcome, run.message_outcome))
    return {
        **actions,
        **{f"message_{name}": value for name, value in messages.items()},
        "n_decisions": float(run.decisions),
        "n_message_decisions": float(run.decisions),
    }
