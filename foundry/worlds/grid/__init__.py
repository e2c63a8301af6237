"""The 2D worlds: a bounded grid with places and fires, where agents talk to their neighbours and move."""

from foundry.worlds.compared import Compared

COMPARED = Compared(
    state=("x", "y", "action", "direction", "x_next", "y_next"),
    acted=("action", "direction"),
    ends=("x_next", "y_next"),
    place=lambda line: (line["x_next"], line["y_next"]),
)
"""The keys by which foundry compares two decisions in 2D worlds."""
