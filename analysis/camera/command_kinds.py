"""What kind of movement a command of a 3D world asks for, whatever its amount."""

from __future__ import annotations

import numpy as np

from analysis.arrays import STAY, FloatArray, IntArray
from analysis.camera.run import CameraRun
from foundry.records import COMMAND_KINDS


def command_kinds(run: CameraRun) -> IntArray:
    """Return the kind of each command, index into COMMAND_KINDS, (T,); what could not be read moves nothing: STAY."""
    found = kinds_of(bearing=run.bearing, asked=run.asked, turn=run.turn, gaze=run.gaze)
    return np.asarray(np.where(run.readable, found, STAY))


def kinds_of(*, bearing: FloatArray, asked: FloatArray, turn: FloatArray, gaze: FloatArray) -> IntArray:
    """Return the kind of each command, index into COMMAND_KINDS, (T,).

    It is that of the translation if it has one, else of the turn, else of the gaze, each by its side; what moves
    nothing, for whatever reason, is a stay. The arguments are those of `CameraRun`, (T,) each.
    """
    # Quarters of the circle of bearings, counter-clockwise: forward, left, back, right.
    quarter = np.floor((np.nan_to_num(bearing) + 45) % 360 / 90).astype(np.int64) % 4
    way = np.array([COMMAND_KINDS.index(name) for name in ("forward", "left", "back", "right")])[quarter]
    turned = np.where(turn > 0, COMMAND_KINDS.index("turn left"), COMMAND_KINDS.index("turn right"))
    gazed = np.where(gaze > 0, COMMAND_KINDS.index("look up"), COMMAND_KINDS.index("look down"))
    return np.asarray(np.select([asked > 0, turn != 0, gaze != 0], [way, turned, gazed], STAY))
