"""What a user needs to know of a USD file to make a world of it: its prims, sizes and labels, and a picture."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from foundry.errors import InputError
from foundry.worlds.camera.eye.overview import OverviewFrame
from foundry.worlds.camera.eye.rendering import png, renderer_for
from foundry.worlds.camera.loading.scene import Scene
from foundry.worlds.camera.loading.scene_files import find_asset
from foundry.worlds.camera.loading.stage import load_scene

WIDTH, HEIGHT, FOV_DEG = 960, 720, 70.0
MOST_LABELS = 40


def describe_scene(path: Path, exclude: Sequence[str], root: Path | None = None) -> Iterator[str]:
    """Yield lines that say what is in a USD file.

    Raises:
        InputError: there is no such file, or it is no USD file.
    """
    scene = load_scene(find_asset(str(path)), exclude=tuple(exclude), root=root)
    low, high = scene.bounds
    yield f"{scene.source}"
    yield f"prims       {scene.prims:,} ({len(scene.meshes):,} drawn as meshes, {scene.triangles:,} triangles)"
    yield f"up axis     {scene.up_axis}, {scene.metres_per_unit:g} metres per unit (shown here with Z up, in metres)"
    yield from (f"{axis}           {low[i]:.2f} to {high[i]:.2f} m" for i, axis in enumerate("xyz"))
    yield f"sha256      {scene.sha256}"
    yield from _tree(scene)
    yield from _labels(scene)
    yield from (f"not drawn   {warning}" for warning in scene.warnings)


def _tree(scene: Scene) -> Iterator[str]:
    """Yield the first two levels of prims with their meshes, as patterns to exclude start there."""
    counts = Counter("/".join(mesh.path.split("/")[:3]) for mesh in scene.meshes)
    yield from (f"{number:9,} meshes below {path}" for path, number in sorted(counts.items()))


def _labels(scene: Scene) -> Iterator[str]:
    named = sorted(scene.labels.items())
    for label, prims in named[:MOST_LABELS]:
        yield f"label       {label}: {', '.join(prims[:3])}{' ...' if len(prims) > 3 else ''}"
    if len(named) > MOST_LABELS:
        yield f"            and {len(named) - MOST_LABELS} more labels"


def shoot_scene(path: Path, exclude: Sequence[str], pose: str | None, root: Path | None = None) -> bytes:
    """Return a PNG of a scene: from a pose "x,y,z,yaw,pitch" of the eye, or from outside.

    Raises:
        InputError: there is no such file, or the pose cannot be read.
    """
    scene = load_scene(find_asset(str(path)), exclude=tuple(exclude), root=root)
    renderer = renderer_for(scene, width=WIDTH, height=HEIGHT, fov_deg=FOV_DEG)
    if pose is None:
        centre = scene.bounds.mean(axis=0)
        foot = np.array([centre[0], centre[1], scene.bounds[0, 2]])
        return png(renderer.overview(OverviewFrame(foot=foot, yaw_deg=0.0, caption=f"{scene.name}, body of 1.75 m")))
    numbers = re.split(r"[,\s]+", pose.strip())
    try:
        x, y, z, yaw, pitch = map(float, numbers)
    except ValueError:
        raise InputError(f"--pose {pose} is not five numbers: x,y,z,yaw,pitch, such as 4,20.1,1.4,180,0.") from None
    return png(renderer.view(np.array([x, y, z]), yaw, pitch))
