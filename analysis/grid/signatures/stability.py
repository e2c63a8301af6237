"""Stability: how much an agent's next action follows from its last one."""

import numpy as np

from analysis.arrays import STAY
from analysis.grid.grid_run import FURTHER_ACTIONS, HEADINGS, GridRun
from analysis.repeats import HEADLINE, MEASURES, repeats

__all__ = ["HEADLINE", "MEASURES", "NAME", "measure"]

NAME = "stability"

_OPPOSITE = np.array(
    [*(np.flatnonzero((-heading == HEADINGS).all(axis=1))[0] for heading in HEADINGS), *(STAY for _ in FURTHER_ACTIONS)]
)


def measure(run: GridRun) -> dict[str, float]:
    """Return the action stability of a run.

    Actions are what was asked for: stay, up, down, left or right, or a further action where there are any, which counts
    as a move without an opposite; a reply that could not be read is a stay. Pairs are two decisions of one agent in a
    row that both count, pooled over agents, never across them.

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
    return repeats(run.choice, run.counted, _OPPOSITE)
