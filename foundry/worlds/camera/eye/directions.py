"""Headings: degrees, counter-clockwise from +X, and upwards."""

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
