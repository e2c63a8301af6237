"""Shows a USD file to users who make a world of it: prims, sizes, labels, and a picture."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from foundry.errors import InputError
from foundry.worlds.camera.eye.overview import OverviewFrame, draw_overview
from foundry.worlds.camera.eye.rendering import png, renderer_for
from foundry.worlds.camera.loading.scene import FloatArray, Scene
from foundry.worlds.camera.loading.stage import load_scene

WIDTH, HEIGHT, FOV_DEG = 960, 720, 70.0
MOST_LABELS = 40
BODY_M = (0.8, 0.8, 1.75)
MARGIN = 1.15
"""Factor by which a view from outside shows more than the scene, so that the caption covers no part of it."""


def describe_scene(path: Path, exclude: Sequence[str], root: Path | None = None) -> Iterator[str]:
    """Yield lines that describe a USD file.

    Raises:
        InputError: the file does not exist or is not a USD file.
    """
    scene = load_scene(path, exclude=exclude, root=root)
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
    """Yield the number of meshes below each prim of the first two levels, which users may exclude by a pattern."""
    counts = Counter("/".join(mesh.path.split("/")[:3]) for mesh in scene.meshes)
    yield from (f"{number:9,} meshes below {path}" for path, number in sorted(counts.items()))


def _labels(scene: Scene) -> Iterator[str]:
    named = sorted(scene.labels.items())
    for label, prims in named[:MOST_LABELS]:
        yield f"label       {label}: {', '.join(prims[:3])}{' ...' if len(prims) > 3 else ''}"
    if len(named) > MOST_LABELS:
        yield f"            and {len(named) - MOST_LABELS} more labels"


def shoot_scene(path: Path, exclude: Sequence[str], pose: str | None, root: Path | None = None) -> bytes:
    """Return a PNG of a scene, seen from an eye at the pose "x,y,z,yaw,pitch"; without a pose, from outside.

    Raises:
        InputError: the file does not exist, or the pose cannot be read.
    """
    scene = load_scene(path, exclude=exclude, root=root)
    if pose is None:
        foot = _foot(scene.bounds)
        caption = f"{scene.name}, body of {BODY_M[2]:g} m"
        bounds = _framed(scene.bounds, foot)
        return png(draw_overview(scene, OverviewFrame(foot=foot, yaw_deg=0.0, caption=caption, bounds=bounds)))
    numbers = re.split(r"[,\s]+", pose.strip())
    try:
        x, y, z, yaw, pitch = map(float, numbers)
    except ValueError:
        raise InputError(f"--pose {pose} is not five numbers: x,y,z,yaw,pitch, such as 4,20.1,1.4,180,0.") from None
    renderer = renderer_for(scene, width=WIDTH, height=HEIGHT, fov_deg=FOV_DEG)
    return png(renderer.view(np.array([x, y, z]), yaw, pitch))


def _foot(bounds: FloatArray) -> FloatArray:
    """Return the foot (3,), metres, of a body that shows the scene's size: in the middle, or beside a small scene."""
    low, high = bounds
    is_small = (high - low).max() < BODY_M[2]
    middle = (low + high) / 2
    return np.array([high[0] + BODY_M[0] / 2 if is_small else middle[0], middle[1], low[2]])


def _framed(bounds: FloatArray, foot: FloatArray) -> FloatArray:
    """Return the box (2, 3) around a scene and a body at `foot` with a margin, metres."""
    aside = np.array([BODY_M[0] / 2, BODY_M[1] / 2, 0.0])
    low = np.minimum(bounds[0], foot - aside)
    high = np.maximum(bounds[1], foot + aside + [0.0, 0.0, BODY_M[2]])
    centre = (low + high) / 2
    return np.array([centre + (low - centre) * MARGIN, centre + (high - centre) * MARGIN])
