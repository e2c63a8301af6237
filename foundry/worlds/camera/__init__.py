"""3D worlds: USD scenes that one agent sees and walks through."""

from foundry.worlds.compared import Compared

COMPARED = Compared(
    state=("pose", "command", "pose_next"),
    acted=("command",),
    ends=("pose_next",),
    place=lambda line: tuple(line["pose_next"][axis] for axis in "xyz"),
    heading=lambda line: line["pose_next"]["yaw"],
)
"""The keys by which two decisions of this form are compared."""
