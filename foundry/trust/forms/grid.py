"""What two decisions in a 2D world are compared by."""

from __future__ import annotations

from foundry.trust.forms import Compared

COMPARED = Compared(
    state=("x", "y", "action", "direction", "x_next", "y_next"),
    acted=("action", "direction"),
    ends=("x_next", "y_next"),
    place=lambda line: (line["x_next"], line["y_next"]),
)
