"""The scene of a run, loaded from its file, and its floor plan."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from foundry.errors import InputError
from foundry.records import CameraEpisode

if TYPE_CHECKING:
    from foundry.worlds.camera.loading.scene import Scene


_ONE_AT_A_TIME = threading.Lock()


def scene_of(run_config: Mapping[str, Any], sha256: str | None) -> Scene | None:
    """Return the scene of a run; None if its world has none.

    Args:
        run_config: the effective configuration of the run.
        sha256: digest that the scene must have, or None.

    Raises:
        InputError: the scene's file is missing or has changed.
    """
    asset = run_config["world"].get("scene")
    if not isinstance(asset, Mapping):
        return None
    from foundry.worlds.camera.loading.stage import load_scene

    with _ONE_AT_A_TIME:  # then the next thread finds it loaded
        scene = load_scene(asset["asset"], exclude=asset["exclude"], root=asset.get("root"))
    if sha256 is not None:
        scene.check_digest(sha256)
    return scene


def plan_of(run_config: Mapping[str, Any], episode: CameraEpisode) -> dict[str, Any]:
    """Return the floor plan at the height of an episode's start.

    It has the keys `walls`, each `[[x, y], [x, y]]` in metres, rounded to centimetres, and `why`: the reason why there
    are none, or "".
    """
    try:
        scene = scene_of(run_config, episode.scene_sha256)
    except InputError as error:
        return {"walls": [], "why": str(error)}
    if scene is None:
        return {"walls": [], "why": ""}
    from foundry.worlds.camera.body.surfaces import section

    corners = np.concatenate([mesh.points[mesh.triangles] for mesh in scene.meshes])
    cut = section(corners, episode.start.z + run_config["world"]["body"]["height"] / 2)
    walls = {tuple(map(tuple, sorted(ends))) for ends in np.round(cut, 2).tolist()}
    return {"walls": sorted(wall for wall in walls if wall[0] != wall[1]), "why": ""}
