"""What two decisions in a 3D world are compared by."""

from __future__ import annotations

from foundry.trust.forms import Compared

COMPARED = Compared(
    state=("pose", "command", "pose_next"),
    acted=("command",),
    ends=("pose_next",),
    place=lambda line: tuple(line["pose_next"][axis] for axis in "xyz"),
    heading=lambda line: line["pose_next"]["yaw"],
)
