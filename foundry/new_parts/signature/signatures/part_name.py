"""The signature part_name: change what it measures to what you ask."""

import math
from collections import Counter

from foundry import AnyRun, share

NAME = "part_name"

MEASURES = {"commonest": share("The commonest action (share of decisions)")}

HEADLINE = ("commonest",)


def measure(run: AnyRun) -> dict[str, float]:
    """Return how common the commonest action of a run is.

    - commonest: decisions for the action that is decided most often / decisions; 0..1.

    NaN without decisions. Denominator: n_decisions.
    """
    decided = [action for action in run.action[run.counted] if action is not None]
    most = max(Counter(decided).values(), default=0)
    return {
        "commonest": most / len(decided) if decided else math.nan,
        "n_decisions": float(len(decided)),
    }
