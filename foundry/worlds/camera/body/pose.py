"""Poses: where a foot stands, and which way the body and its gaze are turned."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from foundry.records import Pose
from foundry.worlds.camera.loading.scene import FloatArray

POSE_DIGITS = 9
"""Poses are kept to the nanometre, so that a recorded one draws the very image of the run."""


def make_pose(foot: FloatArray, yaw: float, pitch: float) -> Pose:
    """Return a pose from a foot position (3,), metres, and angles, degrees."""
    x, y, z = (round(float(value), POSE_DIGITS) + 0.0 for value in foot)
    return Pose(x, y, z, round(yaw % 360.0, POSE_DIGITS) % 360.0, round(pitch, POSE_DIGITS) + 0.0)


def foot_of(pose: Pose) -> FloatArray:
    """Return where the foot (3,) of a pose is, metres."""
    return np.array([pose.x, pose.y, pose.z])


def feet_of(poses: Iterable[Pose]) -> FloatArray:
    """Return where the feet (k, 3) of poses are, metres."""
    return np.array([foot_of(pose) for pose in poses])


def turn_between(before: float, after: float) -> float:
    """Return the turn from one heading to another, degrees, left positive, -180..180."""
    return (after - before + 180.0) % 360.0 - 180.0
