"""Stability: how much an agent's next command follows from its last one."""

import numpy as np

from analysis.camera.camera_run import CameraRun, command_kinds
from analysis.repeats import HEADLINE, MEASURES, repeats

__all__ = ["HEADLINE", "MEASURES", "NAME", "measure"]

NAME = "stability"

_OPPOSITE_KIND = np.array([0, 2, 1, 4, 3, 6, 5, 8, 7])


def measure(run: CameraRun) -> dict[str, float]:
    """Return the action stability of a run of a 3D world, over kinds of command.

    The kind of a command is its translation if it has one, else its turn, else its gaze, each by its side: see
    COMMAND_KINDS; a reply that moves nothing, for whatever reason, counts as stay. Amounts make no difference.
    Pairs are two decisions in a row that both count.

    - persistence: pairs of equal kinds / pairs; 0..1. NaN with fewer than two decisions.
    - repeats_beyond_chance: persistence less that of the same kinds in any order: of n counted decisions, n_k of kind
      k, a pair is equal by chance with sum of n_k (n_k - 1) / (n (n - 1)); -1..1. NaN without pairs.
    - kappa: Cohen's kappa between the kinds of a pair, (p - chance) / (1 - chance); -1..1. NaN when chance is 1.
    - conditional_entropy: H(kind | last kind), bits; 0..log2 9. NaN without pairs; biased low for few of them.
    - reversal_rate: pairs of opposite kinds / pairs of kinds but stay; 0..1: left and right turns, looking up and down,
      going forward and back, and to either side. NaN without such pairs.
    - run_length: mean length of the runs of equal kinds, decisions; 1..T. One that does not count ends a run.

    Denominators: n_pairs, n_move_pairs, n_runs (of equal kinds).
    Source: Cohen 1960 for kappa; Cover and Thomas 2006 for the conditional entropy.
    """
    return repeats(command_kinds(run)[:, None], run.counted[:, None], _OPPOSITE_KIND)
