"""Where points of a scene are in a picture of it."""

from __future__ import annotations

import numpy as np

from foundry.worlds.camera.loading.scene import FloatArray


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
