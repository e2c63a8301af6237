"""What the agent of a 3D world perceives.

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
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from foundry.records import Pose
from foundry.worlds.camera.language.interpreter import Limits
from foundry.worlds.camera.scene import UInt8Array

if TYPE_CHECKING:
    from foundry.worlds.camera.surroundings import Surroundings, Target


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


def observe(
    sight: Sight,
    target: Target | None,
    *,
    step: int,
    task: str,
    history: Sequence[Mapping[str, Any]],
    idle_streak: int,
    limits: Limits,
) -> dict[str, Any]:
    """Return the observation; see the head of this file."""
    pose = sight.pose
    return {
        "task": task,
        "step": step,
        "x": pose.x,
        "y": pose.y,
        "z": pose.z,
        "yaw": pose.yaw,
        "pitch": pose.pitch,
        "history": history,
        "idle_streak": idle_streak,
        "target": target.name if target else "",
        "limits": {
            "max_distance_m": limits.max_distance_m,
            "max_turn_deg": limits.max_turn_deg,
            "max_gaze_deg": limits.max_gaze_deg,
        },
    }


class Secret(Mapping[str, Any]):
    """What scripted models are told beside the observation; worked out when it is asked for, since few ask."""

    def __init__(self, around: Surroundings, sight: Sight, target: Target | None) -> None:
        self._told: dict[str, Callable[[], Any]] = {
            "way": lambda: [] if sight.near else around.way(sight.pose, target).corners,
            "near": lambda: sight.near,
            "reached": lambda: sight.success,
            "target_yaw": lambda: around.direction_of(sight.pose, target)[0],
            "target_pitch": lambda: around.direction_of(sight.pose, target)[1],
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


def angles(offset: Sequence[float]) -> tuple[float, float]:
    """Return the direction (yaw, pitch), degrees, of an offset (x, y, z)."""
    x, y, z = offset
    return math.degrees(math.atan2(y, x)) % 360.0, math.degrees(math.atan2(z, math.hypot(x, y)))
