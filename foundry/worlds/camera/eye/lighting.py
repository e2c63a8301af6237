"""Light that does not move: how bright a surface is depends on the way it faces alone.

It is worked out once for every point of a scene, which makes a picture a third faster than lights of VTK's would.
"""

from __future__ import annotations

import numpy as np

from foundry.worlds.camera.loading.scene import FloatArray

_AMBIENT = 0.6
"""What every surface gets from everywhere, of 1."""

_LIGHTS = np.array([[0.32, 0.18, 0.25], [0.02, 0.10, 0.40]])
"""What comes from +X, +Y, +Z and from -X, -Y, -Z: the six sides of a room are six shades of one colour."""


def brightness(normals: FloatArray) -> FloatArray:
    """Return (n,) how bright surfaces are that face along these (n, 3) unit vectors; at most 1."""
    lit = np.clip(normals, 0, None) @ _LIGHTS[0] + np.clip(-normals, 0, None) @ _LIGHTS[1]
    return np.asarray(np.minimum(_AMBIENT + lit, 1.0))
