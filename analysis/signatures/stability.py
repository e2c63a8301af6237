"""Stability: how much an agent's next action follows from its last one."""

from __future__ import annotations

import math

import numpy as np

from analysis.agreement import cohen_kappa, joint_counts
from analysis.camera_run import CameraRun
from analysis.command_kinds import KINDS, command_kinds
from analysis.described import Measure, Null, share
from analysis.formulas import entropy, ratio, variety, weighted_mean
from analysis.run import HEADINGS, STAY, BoolArray, GridRun, IntArray

NAME = "stability"

MEASURES = {
    "persistence": share("Same action again (share)"),
    "repeats_beyond_chance": Measure(
        "Same action again, beyond chance (difference)", -1, 1, Null(0, "draws its actions one by one")
    ),
    "kappa": Measure("Same action again, beyond chance (kappa)", -1, 1),
    "conditional_entropy": Measure("Entropy of an action given the last (bits)", 0, math.log2(len(KINDS))),
    "reversal_rate": share("Moves straight back (share of move pairs)"),
    "run_length": Measure("Steps of the same action in a row", low=1),
}

HEADLINE = ("persistence", "repeats_beyond_chance", "reversal_rate")

_OPPOSITE = np.array([np.flatnonzero((-heading == HEADINGS).all(axis=1))[0] for heading in HEADINGS])
_OPPOSITE_KIND = np.array([0, 2, 1, 4, 3, 6, 5, 8, 7])


def measure(run: GridRun) -> dict[str, float]:
    """Return the action stability of a run.

    Actions are what was asked for: stay, up, down, left or right; a reply that could not be read is a stay. Pairs are
    two decisions of one agent in a row that both count, pooled over agents, never across them.

    - persistence: pairs of equal actions / pairs; 0..1. NaN with fewer than two steps.
    - repeats_beyond_chance: persistence less that of the same actions of each agent in any order: of n counted actions,
      n_k of kind k, a pair is equal by chance with sum of n_k (n_k - 1) / (n (n - 1)); -1..1. Exact for few actions and
      for agents with different habits. NaN without pairs.
    - kappa: Cohen's kappa between the actions of a pair, (p - chance) / (1 - chance); -1..1. NaN when chance is
      1, that is when only one action is ever taken. Below 0 by about 1/n for n actions drawn one by one.
    - conditional_entropy: H(action | last action), bits; 0..log2 5. NaN without pairs; biased low for few of them.
    - reversal_rate: pairs of opposite moves / pairs of moves; 0..1. NaN without pairs of moves.
    - run_length: mean length of the runs of equal actions, steps; 1..T. A decision that does not count ends a run.

    How stable the answers to one and the same prompt are, is measured over several runs: see `analysis.retest`.
    Denominators: n_pairs, n_move_pairs, n_runs (of equal actions).
    Source: Cohen 1960 for kappa; Cover and Thomas 2006 for the conditional entropy.
    """
    return _measures(run.choice, run.counted, _OPPOSITE)


def measure_camera(run: CameraRun) -> dict[str, float]:
    """Return the action stability of a run of a 3D world: the same measures over kinds of command.

    The kind of a command is its translation if it has one, else its turn, else its gaze, each by its side: see
    KINDS; a reply that moves nothing, for whatever reason, counts as stay. Amounts make no difference. Opposite are
    left and right turns, looking up and down, going forward and back, and to either side; "moves" are all kinds but
    stay. conditional_entropy is at most log2 9 bits.
    """
    return _measures(command_kinds(run)[:, None], run.counted[:, None], _OPPOSITE_KIND)


def _measures(choice: IntArray, counted: BoolArray, opposite: IntArray) -> dict[str, float]:
    """Return the measures.

    Args:
        choice: what was asked for, by step and agent, STAY or other indices, (T, N).
        counted: whether it counts, (T, N).
        opposite: index of the opposite of each choice.
    """
    both = counted[:-1] & counted[1:]
    before, after = choice[:-1][both], choice[1:][both]
    moves = (before != STAY) & (after != STAY)
    # Every decision that counts lengthens a run; it begins one unless it repeats the one before it.
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
    """Return the share of equal pairs if each agent's counted actions came in any order; NaN without pairs.

    Args:
        choice: what was asked for, by step and agent, (T, N).
        counted: whether it counts, (T, N).
        pairs: whether it and the next one count, (T - 1, N).
    """
    able = np.flatnonzero(pairs.any(axis=0))
    alike = [1 - variety(np.bincount(choice[counted[:, agent], agent])) for agent in able.tolist()]
    return weighted_mean(np.array(alike), pairs.sum(axis=0)[able])


def conditional_entropy(before: IntArray, after: IntArray) -> float:
    """Return H(after | before) of two rows of choices (n,), bits; NaN when n is 0."""
    joint = joint_counts(before, after)
    return max(entropy(joint) - entropy(joint.sum(axis=1)), 0.0) if len(before) else math.nan
