"""From a command to the pose after it: turn of the body, turn of the gaze, then translation."""

from __future__ import annotations

from dataclasses import dataclass

from foundry.records import Pose
from foundry.worlds.camera.body.collision import Body, Collider
from foundry.worlds.camera.body.pose import POSE_DIGITS, foot_of, make_pose
from foundry.worlds.camera.language import Command


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


def moved(pose: Pose, command: Command, collider: Collider, body: Body, *, pitch_limit: float, slide: bool) -> Moved:
    """Return what comes of a command; the same everywhere and always.

    Args:
        pose: before it.
        command: what is asked for.
        collider: what the body may hit.
        body: the body.
        pitch_limit: how far the gaze turns up or down, degrees.
        slide: whether the body goes on along what it hits, or stops there.
    """
    if command.idle:
        return Moved(pose, None, 0.0, (pose,), ())
    yaw = (pose.yaw + (command.turn or 0.0)) % 360.0
    wanted = pose.pitch + (command.gaze or 0.0)
    pitch = min(max(wanted, -pitch_limit), pitch_limit)
    notes = (f"gaze clamped to {pitch:+.0f} deg",) if pitch != wanted else ()
    foot = foot_of(pose)
    turned = make_pose(foot, yaw, pitch)
    translate = command.translate
    if translate is None or not translate.distance:
        return Moved(turned, "gaze limit" if notes else None, 0.0, (turned,), notes)
    motion = collider.move(foot, yaw + translate.bearing, translate.distance, body, slide=slide)
    return Moved(
        make_pose(motion.foot, yaw, pitch),
        motion.stopped_by or ("gaze limit" if notes else None),
        round(float(motion.travelled_m), POSE_DIGITS),
        tuple(make_pose(place, yaw, pitch) for place in motion.track),
        notes,
    )
