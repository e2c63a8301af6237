"""Headings (degrees, counter-clockwise from +X, and upwards), and where points are in a picture."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from foundry.worlds.camera.loading.scene import FloatArray


def direction(yaw_deg: float, pitch_deg: float) -> FloatArray:
    """Return the (3,) unit vector of a heading and a pitch."""
    yaw, pitch = np.radians(yaw_deg), np.radians(pitch_deg)
    return np.array([np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), np.sin(pitch)])


def angles(offset: Sequence[float] | FloatArray) -> tuple[float, float]:
    """Return the heading and the pitch of an offset (3,), degrees."""
    x, y, z = offset
    return math.degrees(math.atan2(y, x)) % 360.0, math.degrees(math.atan2(z, math.hypot(x, y)))


def offsets_from(eye: FloatArray, ahead: FloatArray, up: FloatArray, points: FloatArray) -> FloatArray:
    """Return how far (..., 3) points are to the right, upwards and ahead of an eye with these unit axes, metres."""
    axes = np.column_stack([np.cross(ahead, up), up, ahead])
    return np.asarray((points - eye) @ axes)


def in_picture(offsets: FloatArray, frame: tuple[int, int], fov_deg: float) -> FloatArray:
    """Return the (..., 2) pixels, to the right and down, at which (..., 3) offsets ahead of the eye are drawn.

    Args:
        offsets: as by `offsets_from`; all of them ahead.
        frame: width and height of the picture, pixels.
        fov_deg: its vertical angle of view.
    """
    scale = frame[1] / 2 / np.tan(np.radians(fov_deg) / 2) / offsets[..., 2]
    return np.stack([frame[0] / 2 + offsets[..., 0] * scale, frame[1] / 2 - offsets[..., 1] * scale], axis=-1)
