"""The signature part_name: replace its measure by your own."""

import math
from collections import Counter

from foundry import AnyRun, share

NAME = "part_name"

MEASURES = {"commonest": share("Most frequent action (share of decisions)")}

HEADLINE = ("commonest",)


def measure(run: AnyRun) -> dict[str, float]:
    """Return the share of the most frequent action of a run.

    - commonest: decisions for the most frequent action / decisions; 0..1.

    NaN without decisions. Denominator: n_decisions.
    """
    decided = [action for action in run.action[run.counted] if action is not None]
    most = max(Counter(decided).values(), default=0)
    return {
        "commonest": most / len(decided) if decided else math.nan,
        "n_decisions": float(len(decided)),
    }
