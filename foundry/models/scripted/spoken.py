"""What scripted policies of 3D worlds share: sentences that the interpreter reads."""

from __future__ import annotations

AIM_DEG = 2.0
"""Heading or gaze that is off by less is not corrected."""


def off_by(wanted_deg: float, actual_deg: float) -> float:
    """Return how far to turn from the actual to the wanted direction, degrees, left positive, -180..180."""
    return (wanted_deg - actual_deg + 180.0) % 360.0 - 180.0


def turn(degrees: float) -> str:
    """Return the sentence that turns the body, left positive."""
    return f"Turn {'left' if degrees > 0 else 'right'} {abs(degrees):.2f} degrees."


def gaze(degrees: float) -> str:
    """Return the sentence that turns the gaze, up positive."""
    return f"Look {'up' if degrees > 0 else 'down'} {abs(degrees):.2f} degrees."


def forward(metres: float) -> str:
    """Return the sentence that moves the body ahead."""
    return f"Move forward {metres:.3f} m."


STAY = "Stay."
