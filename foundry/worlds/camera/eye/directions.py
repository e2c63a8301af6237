"""Headings: degrees, counter-clockwise from +X, and upwards."""

from __future__ import annotations

import numpy as np

from foundry.worlds.camera.scene import FloatArray


def direction(yaw_deg: float, pitch_deg: float) -> FloatArray:
    """Return the (3,) unit vector of a heading and a pitch."""
    yaw, pitch = np.radians(yaw_deg), np.radians(pitch_deg)
    return np.array([np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), np.sin(pitch)])
