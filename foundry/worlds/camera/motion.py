"""From a command to the pose after it: turn of the body, turn of the gaze, then translation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from foundry.records import Pose
from foundry.worlds.camera.language.interpreter import Command
from foundry.worlds.camera.scene import FloatArray

if TYPE_CHECKING:
    from foundry.worlds.camera.settings import UsdSettings
    from foundry.worlds.camera.surroundings import Surroundings

POSE_DIGITS = 9
"""Poses are kept to the nanometre, so that a recorded one draws the very image of the run."""


@dataclass(frozen=True)
class Moved:
    """What came of a command.

    Attributes:
        pose: after the motion.
        boundary: what stopped or clamped the motion, or None.
        travelled: length of the way, metres.
        places: where the foot was on the way, the end included.
        notes: what was clamped.
    """

    pose: Pose
    boundary: str | None
    travelled: float
    places: tuple[Pose, ...]
    notes: tuple[str, ...]


def moved(pose: Pose, command: Command, around: Surroundings, settings: UsdSettings) -> Moved:
    """Return what comes of a command; the same everywhere and always."""
    if command.idle:
        return Moved(pose, None, 0.0, (pose,), ())
    yaw = (pose.yaw + (command.turn or 0.0)) % 360.0
    wanted = pose.pitch + (command.gaze or 0.0)
    limit = settings.camera.pitch_limit
    pitch = min(max(wanted, -limit), limit)
    notes = (f"gaze clamped to {pitch:+.0f} deg",) if pitch != wanted else ()
    foot = foot_of(pose)
    turned = make_pose(foot, yaw, pitch)
    translate = command.translate
    if translate is None or not translate.distance:
        return Moved(turned, "gaze limit" if notes else None, 0.0, (turned,), notes)
    motion = around.collider.move(
        foot, yaw + translate.bearing, translate.distance, around.body, slide=settings.boundary == "slide"
    )
    places = tuple(make_pose(place, yaw, pitch) for place in motion.track)
    return Moved(
        make_pose(motion.foot, yaw, pitch),
        motion.stopped_by or ("gaze limit" if notes else None),
        round(float(motion.travelled_m), POSE_DIGITS),
        places,
        notes,
    )


def foot_of(pose: Pose) -> FloatArray:
    """Return where the foot (3,) of a pose is, metres."""
    return np.array([pose.x, pose.y, pose.z])


def feet_of(poses: Iterable[Pose]) -> FloatArray:
    """Return where the feet (k, 3) of poses are, metres."""
    return np.array([foot_of(pose) for pose in poses])


def make_pose(foot: FloatArray, yaw: float, pitch: float) -> Pose:
    """Return a pose from a foot position (3,), metres, and angles, degrees."""
    x, y, z = (round(float(value), POSE_DIGITS) + 0.0 for value in foot)
    return Pose(x, y, z, round(yaw % 360.0, POSE_DIGITS) % 360.0, round(pitch, POSE_DIGITS) + 0.0)
