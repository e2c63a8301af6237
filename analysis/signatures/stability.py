"""Stability: how much an agent's next action follows from its last one."""

from __future__ import annotations

import math

import numpy as np

from analysis.camera_run import CameraRun
from analysis.described import Measure, share
from analysis.formulas import entropy, mean, ratio, run_lengths
from analysis.run import HEADINGS, STAY, BoolArray, GridRun, IntArray

NAME = "stability"

KINDS = ("stay", "forward", "back", "left", "right", "turn left", "turn right", "look up", "look down")
"""Kinds of command in 3D worlds."""

MEASURES = {
    "persistence": share("Same action again (share)"),
    "persistence_readable": share("Same action again, readable decisions (share)"),
    "kappa": Measure("Same action again, beyond chance (kappa)", -1, 1),
    "kappa_readable": Measure("Same action again, beyond chance, readable (kappa)", -1, 1),
    "conditional_entropy": Measure("Entropy of an action given the last (bits)", 0, math.log2(len(KINDS))),
    "reversal_rate": share("Moves straight back (share of move pairs)"),
    "run_length": Measure("Steps of the same action in a row", low=1),
}

HEADLINE = ("persistence", "kappa", "reversal_rate")

_OPPOSITE = np.array([np.flatnonzero((-heading == HEADINGS).all(axis=1))[0] for heading in HEADINGS])
_OPPOSITE_KIND = np.array([0, 2, 1, 4, 3, 6, 5, 8, 7])


def measure(run: GridRun) -> dict[str, float]:
    """Return the action stability of a run.

    Actions are what was asked for: stay, up, down, left or right; a reply that could not be read counts as
    stay. Pairs are two steps of one agent in a row, pooled over agents, never across them.

    - persistence: pairs of equal actions / pairs; 0..1. NaN with fewer than two steps.
    - kappa: Cohen's kappa between the actions of a pair, (p - chance) / (1 - chance); -1..1. NaN when chance is
      1, that is when only one action is ever taken.
    - persistence_readable, kappa_readable: the same over pairs whose two decisions could be read.
    - conditional_entropy: H(action | last action), bits; 0..log2 5.
    - reversal_rate: pairs of opposite moves / pairs of moves; 0..1. NaN without pairs of moves.
    - run_length: mean length of the runs of equal actions, steps; 1..T.

    Denominators: n_pairs, n_readable_pairs, n_move_pairs.
    """
    return _measures(run.choice, run.readable, _OPPOSITE)


def measure_camera(run: CameraRun) -> dict[str, float]:
    """Return the action stability of a run of a 3D world: the same measures over kinds of command.

    The kind of a command is its translation if it has one, else its turn, else its gaze, each by its side: see
    KINDS; a reply that moves nothing, for whatever reason, counts as stay. Amounts make no difference. Opposite are
    left and right turns, looking up and down, going forward and back, and to either side; "moves" are all kinds but
    stay. conditional_entropy is at most log2 9 bits.
    """
    return _measures(_kinds(run)[:, None], run.readable[:, None], _OPPOSITE_KIND)


def _kinds(run: CameraRun) -> IntArray:
    """Return the kind of each command, index into KINDS, (T,)."""
    # Quarters of the circle of bearings, counter-clockwise: forward, left, back, right.
    quarter = np.floor((np.nan_to_num(run.bearing) + 45) % 360 / 90).astype(np.int64)
    way = np.array([KINDS.index(name) for name in ("forward", "left", "back", "right")])[quarter]
    turn = np.where(run.turn > 0, KINDS.index("turn left"), KINDS.index("turn right"))
    gaze = np.where(run.gaze > 0, KINDS.index("look up"), KINDS.index("look down"))
    found = np.select([run.asked > 0, run.turn != 0, run.gaze != 0], [way, turn, gaze], STAY)
    return np.asarray(np.where(run.readable, found, STAY))


def _measures(choice: IntArray, valid: BoolArray, opposite: IntArray) -> dict[str, float]:
    """Return the measures.

    Args:
        choice: what was asked for, by step and agent, STAY or other indices, (T, N).
        valid: whether it could be read, (T, N).
        opposite: index of the opposite of each choice.
    """
    before, after = choice[:-1].ravel(), choice[1:].ravel()
    readable: BoolArray = (valid[:-1] & valid[1:]).ravel()
    moves = (before != STAY) & (after != STAY)
    lengths = [run_lengths(row) for row in choice.T if len(row)]
    return {
        "persistence": mean(before == after),
        "persistence_readable": mean((before == after)[readable]),
        "kappa": kappa(before, after),
        "kappa_readable": kappa(before[readable], after[readable]),
        "conditional_entropy": conditional_entropy(before, after),
        "reversal_rate": ratio(int((opposite[before] == after)[moves].sum()), int(moves.sum())),
        "run_length": mean(length for row in lengths for length in row.tolist()),
        "n_pairs": float(len(before)),
        "n_readable_pairs": float(readable.sum()),
        "n_move_pairs": float(moves.sum()),
    }


def _joint(before: IntArray, after: IntArray) -> IntArray:
    """Return how often each pair of choices occurs, (choices, choices)."""
    size = int(max(before.max(initial=STAY), after.max(initial=STAY))) + 1
    return np.bincount(before * size + after, minlength=size * size).reshape(size, size)


def kappa(before: IntArray, after: IntArray) -> float:
    """Return Cohen's kappa of two rows of choices (n,); NaN when chance agreement is 1 or n is 0."""
    joint, pairs = _joint(before, after), len(before)
    # In whole numbers, times pairs squared, so that chance agreement of 1 is met exactly.
    agreed = pairs * int(np.trace(joint))
    chance = int((joint.sum(axis=0) * joint.sum(axis=1)).sum())
    return ratio(agreed - chance, pairs * pairs - chance)


def conditional_entropy(before: IntArray, after: IntArray) -> float:
    """Return H(after | before) of two rows of choices (n,), bits; NaN when n is 0."""
    joint = _joint(before, after)
    return max(entropy(joint) - entropy(joint.sum(axis=1)), 0.0) if len(before) else math.nan
