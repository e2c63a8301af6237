"""Stability: how much an agent's next action depends on its previous one."""

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
    """Return how steadily the agents of a run repeat their actions.

    Actions are as requested: stay, up, down, left, right, or a further action, which counts as a move without an
    opposite. An unreadable reply is a stay. A pair is two successive decisions of one agent that both count; pairs are
    pooled over agents.

    - persistence: pairs of equal actions / pairs; 0..1. NaN with fewer than two steps.
    - repeats_beyond_chance: persistence minus its expectation if each agent's actions came in random order; -1..1. If
      n_k of an agent's n counted actions are of kind k, a pair is equal by chance with probability sum of n_k (n_k - 1)
      / (n (n - 1)). This is exact even for few actions and for agents with different habits. NaN without pairs.
    - kappa: Cohen's kappa between the actions of a pair, (p - chance) / (1 - chance); -1..1. NaN if chance is 1, that
      is, if only one action occurs. Independent draws of n actions give about -1/n.
    - conditional_entropy: H(action | previous action), bits; 0..log2 5. NaN without pairs; it is biased low for few
      pairs.
    - reversal_rate: pairs of opposite moves / pairs of moves; 0..1. NaN without pairs of moves.
    - run_length: mean number of equal actions in a row; 1..T. A decision that does not count ends a row.

    `analysis.retest` measures the stability of answers to the same prompt, over several runs. Denominators: n_pairs,
    n_move_pairs, n_runs (rows of equal actions). Source: Cohen 1960 for kappa; Cover and Thomas 2006 for the
    conditional entropy.
    """
    return repeats(run.choice, run.counted, _OPPOSITE)
