"""What kind of movement a command of a 3D world asks for, whatever its amount."""

from __future__ import annotations

import numpy as np

from analysis.camera_run import CameraRun
from analysis.run import STAY, IntArray

KINDS = ("stay", "forward", "back", "left", "right", "turn left", "turn right", "look up", "look down")
"""Kinds of command; the first is STAY."""


def command_kinds(run: CameraRun) -> IntArray:
    """Return the kind of each command, index into KINDS, (T,).

    It is that of the translation if it has one, else of the turn, else of the gaze, each by its side; what moves
    nothing, for whatever reason, is a stay.
    """
    # Quarters of the circle of bearings, counter-clockwise: forward, left, back, right.
    quarter = np.floor((np.nan_to_num(run.bearing) + 45) % 360 / 90).astype(np.int64) % 4
    way = np.array([KINDS.index(name) for name in ("forward", "left", "back", "right")])[quarter]
    turn = np.where(run.turn > 0, KINDS.index("turn left"), KINDS.index("turn right"))
    gaze = np.where(run.gaze > 0, KINDS.index("look up"), KINDS.index("look down"))
    found = np.select([run.asked > 0, run.turn != 0, run.gaze != 0], [way, turn, gaze], STAY)
    return np.asarray(np.where(run.readable, found, STAY))
