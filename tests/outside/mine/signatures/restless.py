"""Restlessness, of any form: how often the last action is taken again at once."""

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.formulas import mean
from analysis.measure import share

NAME = "restless"

PRIMARY = False

MEASURES = {"change": share("Steps with another action than the one before (share)")}

HEADLINE = ("change",)


def measure(run: AnyRun) -> dict[str, float]:
    """Return how often agents change what they do.

    - change: pairs of decisions in a row of an agent that differ / such pairs; 0..1.

    NaN without pairs. Denominator: n_pairs.
    """
    changed = [
        run.action[own][1:] != run.action[own][:-1]
        for own in (np.flatnonzero((run.agent == agent) & run.counted) for agent in range(run.agents))
    ]
    pairs = np.concatenate(changed) if changed else np.zeros(0)
    return {"change": mean(pairs), "n_pairs": float(len(pairs))}
