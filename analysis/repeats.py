"""Measures of how an agent's action depends on its previous action, for the signatures of several forms."""

import math

import numpy as np

from analysis.agreement import cohen_kappa, joint_counts
from analysis.arrays import STAY, BoolArray, IntArray
from analysis.formulas import entropy, ratio, variety, weighted_mean
from analysis.measure import Measure, Null, share

_MOST_CHOICES = 9
"""Upper limit of the number of different choices of an agent; no form has more."""

MEASURES = {
    "persistence": share("Same action again (share)", says="repeats its last action {more|less} often"),
    "repeats_beyond_chance": Measure(
        "Same action again, beyond chance (difference)", -1, 1, Null(0, "draws its actions independently")
    ),
    "kappa": Measure("Same action again, beyond chance (kappa)", -1, 1),
    "conditional_entropy": Measure("Entropy of an action given the last (bits)", 0, math.log2(_MOST_CHOICES)),
    "reversal_rate": share("Moves straight back (share of move pairs)"),
    "run_length": Measure("Steps of the same action in a row", low=1),
}

HEADLINE = ("persistence", "repeats_beyond_chance", "reversal_rate")


def repeats(choice: IntArray, counted: BoolArray, opposite: IntArray) -> dict[str, float]:
    """Return the measures named in `MEASURES`, and the denominators of these measures.

    Args:
        choice: index of the requested action by step and agent, (T, N); STAY if the agent is idle.
        counted: whether the decision counts, (T, N).
        opposite: index of the opposite of each choice, (choices,).
    """
    both = counted[:-1] & counted[1:]
    before, after = choice[:-1][both], choice[1:][both]
    moves = (before != STAY) & (after != STAY)
    # Every counted decision lengthens a run; it begins a new run unless it repeats the decision before.
    decisions, repeats = int(counted.sum()), int((before == after).sum())
    return {
        "persistence": ratio(repeats, len(before)),
        "repeats_beyond_chance": ratio(repeats, len(before)) - _chance_of_repeating(choice, counted, both),
        "kappa": cohen_kappa(before, after),
        "conditional_entropy": conditional_entropy(before, after),
        "reversal_rate": ratio(int((opposite[before] == after)[moves].sum()), int(moves.sum())),
        "run_length": ratio(decisions, decisions - repeats),
        "n_pairs": float(len(before)),
        "n_move_pairs": float(moves.sum()),
        "n_runs": float(decisions - repeats),
    }


def _chance_of_repeating(choice: IntArray, counted: BoolArray, pairs: BoolArray) -> float:
    """Return the share of repeats expected if each agent took its counted actions in random order; NaN without pairs.

    `choice` and `counted` are as in `repeats`; `pairs` tells whether a decision and the next one count, (T - 1, N).
    """
    able = np.flatnonzero(pairs.any(axis=0))
    alike = [1 - variety(np.bincount(choice[counted[:, agent], agent])) for agent in able.tolist()]
    return weighted_mean(np.array(alike), pairs.sum(axis=0)[able])


def conditional_entropy(before: IntArray, after: IntArray) -> float:
    """Return the entropy of `after` given `before`, H(after | before), in bits; both are (n,). NaN if n is 0."""
    joint = joint_counts(before, after)
    return max(entropy(joint) - entropy(joint.sum(axis=1)), 0.0) if len(before) else math.nan
