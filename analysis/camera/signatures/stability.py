"""Stability: how much an agent's next command depends on its previous one."""

import numpy as np

from analysis.camera.camera_run import CameraRun, command_kinds
from analysis.repeats import HEADLINE, MEASURES, repeats

__all__ = ["HEADLINE", "MEASURES", "NAME", "measure"]

NAME = "stability"

_OPPOSITE_KIND = np.array([0, 2, 1, 4, 3, 6, 5, 8, 7])


def measure(run: CameraRun) -> dict[str, float]:
    """Return how steadily the agent of a 3D world repeats kinds of command.

    The kind of a command is its translation if it has one, else its turn, else its gaze, each by direction (see
    COMMAND_KINDS). A reply that moves nothing counts as stay. Amounts do not matter. A pair is two successive decisions
    that both count.

    - persistence: pairs of equal kinds / pairs; 0..1. NaN with fewer than two decisions.
    - repeats_beyond_chance: persistence minus its expectation if these kinds came in random order; -1..1. If n_k of n
      counted decisions are of kind k, a pair is equal by chance with probability sum of n_k (n_k - 1) / (n (n
      - 1)). NaN without pairs.
    - kappa: Cohen's kappa between the kinds of a pair, (p - chance) / (1 - chance); -1..1. NaN if chance is 1.
    - conditional_entropy: H(kind | last kind), bits; 0..log2 9. NaN without pairs; it is biased low for few pairs.
    - reversal_rate: pairs of opposite kinds / pairs of kinds other than stay; 0..1. Opposites are left and right, up
      and down, forward and back. NaN without such pairs.
    - run_length: mean length of the runs of equal kinds, decisions; 1..T. An uncounted decision ends a run.

    Denominators: n_pairs, n_move_pairs, n_runs (of equal kinds).
    Source: Cohen 1960 for kappa; Cover and Thomas 2006 for the conditional entropy.
    """
    return repeats(command_kinds(run)[:, None], run.counted[:, None], _OPPOSITE_KIND)
