"""What kind of movement a command of a 3D world asks for, whatever its amount."""

from __future__ import annotations

import numpy as np

from analysis.arrays import STAY, FloatArray, IntArray
from analysis.camera.run import CameraRun
from foundry.records import COMMAND_KINDS, command_kind


def command_kinds(run: CameraRun) -> IntArray:
    """Return the kind of each command, index into COMMAND_KINDS, (T,); what could not be read moves nothing: STAY."""
    found = kinds_of(bearing=run.bearing, asked=run.asked, turn=run.turn, gaze=run.gaze)
    return np.asarray(np.where(run.readable, found, STAY))


def kinds_of(*, bearing: FloatArray, asked: FloatArray, turn: FloatArray, gaze: FloatArray) -> IntArray:
    """Return the kind of each command, index into COMMAND_KINDS, (T,); the arguments are those of `CameraRun`."""
    amounts = zip(bearing.tolist(), asked.tolist(), turn.tolist(), gaze.tolist(), strict=True)
    return np.array([COMMAND_KINDS.index(command_kind(*one)) for one in amounts], dtype=np.int64)
