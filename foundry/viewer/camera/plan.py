"""The floor plan of a 3D run's scene: what stands at half the body's height, seen from above."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from foundry.errors import InputError
from foundry.records import CameraEpisode
from foundry.viewer.camera.scenes import scene_of


def plan_of(run_config: Mapping[str, Any], episode: CameraEpisode) -> dict[str, Any]:
    """Return the plan at the level where an episode starts.

    Args:
        run_config: the effective configuration of the run.
        episode: the facts of its episode.

    Returns:
        `walls`, `[[x, y], [x, y]]` each, metres to the centimetre, and `why` there are none, or an empty text.
    """
    try:
        scene = scene_of(run_config, episode.scene_sha256)
    except InputError as error:
        return {"walls": [], "why": str(error)}
    if scene is None:
        return {"walls": [], "why": ""}
    from foundry.worlds.camera.body.surfaces import section

    corners = np.concatenate([mesh.points[mesh.triangles] for mesh in scene.meshes])
    found = section(corners, episode.start.z + run_config["world"]["body"]["height"] / 2)
    walls = {tuple(map(tuple, sorted(ends))) for ends in np.round(found, 2).tolist()}
    return {"walls": sorted(wall for wall in walls if wall[0] != wall[1]), "why": ""}
