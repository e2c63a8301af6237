"""What is seen from a pose, what is true of it, and which of it the agent of a 3D world is told.

Keys of the observation; the image goes with the question, not with the observation:

task          the task's text.
step          0-based decision, as in the paper.
x, y, z       foot, metres.
yaw, pitch    heading and gaze, degrees.
history       earlier decisions, oldest first: [{step, reply, outcome, pose {x, y, z, yaw, pitch}}].
idle_streak   latest decisions in a row that moved nothing.
target        name of what is to be found, or "".
limits        {max_distance_m, max_turn_deg, max_gaze_deg}.

No template can name the following, which `secret` tells scripted models that know the way:

way           corners of the shortest path to the goal: [[x, y]], metres.
near          whether the goal's distance is reached.
reached       whether the target is in view as well.
target_yaw    direction of the target's middle from the eye, degrees.
target_pitch  the same, up positive.
in_view       whether the target is in view.
stopped       whether something was in the way of the last movement.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image

from foundry.records import Pose
from foundry.worlds.camera.body.pose import foot_of
from foundry.worlds.camera.eye.rendering import angles, png
from foundry.worlds.camera.loading.scene import UInt8Array
from foundry.worlds.camera.surroundings import Surroundings, Target

JPEG_QUALITY = 90


@dataclass(frozen=True, eq=False)
class Sight:
    """What is seen from a pose, and what is true of it.

    Attributes:
        pose: where from.
        image: (h, w, 3) RGB.
        encoded: the image as it is sent.
        visible_px: pixels of every labelled thing in view, by label.
        target_px: pixels of the target.
        distance: geodesic distance to the goal, metres; None when it cannot be reached or there is none.
        near: whether the foot is within the target's radius, with no wall in between.
        line_of_sight: whether a straight line from the eye reaches the target.
    """

    pose: Pose
    image: UInt8Array
    encoded: bytes
    visible_px: dict[str, int]
    target_px: int
    distance: float | None
    near: bool
    line_of_sight: bool

    @property
    def success(self) -> bool:
        """Whether the goal is reached: near enough, and in view."""
        return self.near and self.target_px > 0


def look(around: Surroundings, pose: Pose, target: Target | None) -> Sight:
    """Return what is seen from a pose, and what is true of it."""
    eye, renderer, foot = around.eye(pose), around.renderer(), foot_of(pose)
    image = renderer.view(eye, pose.yaw, pose.pitch)
    pixels = renderer.visible(eye, pose.yaw, pose.pitch)
    clear = target is not None and around.navigator.line_of_sight(eye, target.surfaces)
    return Sight(
        pose=pose,
        image=image,
        encoded=_encoded(image, around.settings.image_format),
        visible_px=_by_label(pixels, around.labels),
        target_px=sum(pixels.get(path, 0) for path in target.paths) if target else 0,
        distance=_finite(around.navigator.distance(foot, target.ways)) if target else None,
        near=clear and target is not None and target.surfaces.gap(foot) <= target.radius,
        line_of_sight=clear,
    )


def encoded_view(around: Surroundings, pose: Pose) -> bytes:
    """Return what is seen from a pose as it is sent."""
    image = around.renderer().view(around.eye(pose), pose.yaw, pose.pitch)
    return _encoded(image, around.settings.image_format)


def _encoded(image: UInt8Array, image_format: str) -> bytes:
    """Return (h, w, 3) RGB as it is sent: PNG or JPEG; the same pixels give the same bytes."""
    if image_format == "png":
        return png(image)
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, "JPEG", quality=JPEG_QUALITY)
    return buffer.getvalue()


def _by_label(pixels: Mapping[str, int], labels: Mapping[str, str | None]) -> dict[str, int]:
    found: dict[str, int] = {}
    for path, count in pixels.items():
        label = labels.get(path)
        if label is not None:
            found[label] = found.get(label, 0) + count
    return dict(sorted(found.items()))


def _finite(value: float) -> float | None:
    return round(float(value), 9) if np.isfinite(value) else None


class Secret(Mapping[str, Any]):
    """What scripted models are told beside the observation; worked out when it is asked for, since few ask."""

    def __init__(self, around: Surroundings, sight: Sight, target: Target | None, stopped: bool) -> None:
        self._told: dict[str, Callable[[], Any]] = {
            "way": lambda: [] if sight.near else around.way(sight.pose, target).corners,
            "near": lambda: sight.near,
            "reached": lambda: sight.success,
            "target_yaw": lambda: _direction_of(around, sight.pose, target)[0],
            "target_pitch": lambda: _direction_of(around, sight.pose, target)[1],
            "in_view": lambda: sight.target_px > 0,
            "stopped": lambda: stopped,
        }

    def __getitem__(self, key: str) -> Any:
        """Return what is told under a key."""
        return self._told[key]()

    def __iter__(self) -> Iterator[str]:
        """Iterate over the keys."""
        return iter(self._told)

    def __len__(self) -> int:
        """Return the number of keys."""
        return len(self._told)


def _direction_of(around: Surroundings, pose: Pose, target: Target | None) -> tuple[float | None, float | None]:
    """Return the direction (yaw, pitch), degrees, of the target's middle from the eye."""
    if target is None:
        return None, None
    return angles(target.surfaces.points.mean(axis=0) - around.eye(pose))
