"""Stability: how much an agent's next command follows from its last one."""

from __future__ import annotations

import numpy as np

from analysis.camera.command_kinds import command_kinds
from analysis.camera.run import CameraRun
from analysis.repeats import HEADLINE, MEASURES, repeats

__all__ = ["HEADLINE", "MEASURES", "NAME", "measure"]

NAME = "stability"

_OPPOSITE_KIND = np.array([0, 2, 1, 4, 3, 6, 5, 8, 7])


def measure(run: CameraRun) -> dict[str, float]:
    """Return the action stability of a run of a 3D world: the same measures over kinds of command.

    The kind of a command is its translation if it has one, else its turn, else its gaze, each by its side: see
    COMMAND_KINDS; a reply that moves nothing, for whatever reason, counts as stay. Amounts make no difference. Opposite
    are left and right turns, looking up and down, going forward and back, and to either side; "moves" are all kinds but
    stay. conditional_entropy is at most log2 9 bits.
    """
    return repeats(command_kinds(run)[:, None], run.counted[:, None], _OPPOSITE_KIND)
