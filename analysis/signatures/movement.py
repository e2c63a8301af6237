"""Movement: which ways agents go."""

from __future__ import annotations

import math

import numpy as np

from analysis.described import Measure, share
from analysis.formulas import entropy, normalised_entropy, ratio
from analysis.run import CHOICES, HEADINGS, STAY, GridRun, IntArray

NAME = "movement"

MEASURES = {
    "direction_entropy": share("Entropy of directions moved (of its maximum)"),
    "direction_bits": Measure("Entropy of directions moved (bits)", 0, 2),
    "asked_entropy": share("Entropy of directions asked for (of its maximum)"),
    "resultant_length": share("Mean resultant length of moves"),
    "share_*": share("Moves * (share of moves)"),
}

HEADLINE = ("direction_entropy", "resultant_length")


def measure(run: GridRun) -> dict[str, float]:
    """Return the movement preference of a run, over the moves of all agents together.

    - direction_bits: entropy of the four directions among moves made, bits; 0..2.
    - direction_entropy: the same / 2; 0..1. Biased low below about 30 moves; edges change what is possible, so
      the null is a walker in the same world, not 1.
    - asked_entropy: the same over the moves asked for, made or blocked: the model's bias, not the world's.
    - resultant_length: length of the mean unit vector of the moves made; 0 (balanced)..1 (one direction).
    - share_<direction>: moves made in this direction / moves made; 0..1.

    All are NaN without moves (asked_entropy: without moves asked for). Denominators: n_moves, n_asked.
    """
    asked = np.bincount(run.choice.ravel(), minlength=len(CHOICES))[STAY + 1 :]
    made = np.bincount(run.choice[run.moved], minlength=len(CHOICES))[STAY + 1 :]
    moves = int(made.sum())
    return {
        "direction_entropy": normalised_entropy(made),
        "direction_bits": entropy(made),
        "asked_entropy": normalised_entropy(asked),
        "resultant_length": resultant_length(made),
        **{f"share_{name}": ratio(int(n), moves) for name, n in zip(CHOICES[STAY + 1 :], made, strict=True)},
        "n_moves": float(moves),
        "n_asked": float(asked.sum()),
    }


def resultant_length(counts: IntArray) -> float:
    """Return the length of the mean unit vector, 0..1; counts of up, down, left, right (4,)."""
    sums = (counts[:, None] * HEADINGS[STAY + 1 :]).sum(axis=0)
    return ratio(math.hypot(*sums.tolist()), float(counts.sum()))
