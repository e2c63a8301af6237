"""The agent as others would see it: a person in red, one metre wide parts scaled to the body's height."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from foundry.worlds.camera.loading.placing import placed
from foundry.worlds.camera.loading.polydata import corner_normals
from foundry.worlds.camera.loading.scene import Colour, FloatArray, SceneMesh
from foundry.worlds.camera.loading.shapes import capsule, cylinder, sphere
from foundry.worlds.camera.loading.topology import Topology

RED: Colour = (0.86, 0.08, 0.12)
TRAIL: Colour = (0.95, 0.45, 0.0)
_DARK_RED: Colour = (0.62, 0.04, 0.08)
_SKIN: Colour = (0.93, 0.76, 0.62)
_HAIR: Colour = (0.20, 0.15, 0.12)

_FULL_HEIGHT_M = 1.75


def avatar_meshes(height_m: float) -> list[SceneMesh]:
    """Return a person who stands at the origin and looks along +X."""
    parts = [
        _part(sphere(0.13), (0, 0, 1.60), _SKIN),
        _part(sphere(0.135), (-0.03, 0, 1.63), _HAIR),
        _part(cylinder(0.03, 0.0, 0.10, "X"), (0.15, 0, 1.59), _SKIN),
        _part(capsule(0.17, 0.20, 0.38, "Z"), (0, 0, 1.14), RED),
    ]
    for side in (-1, 1):
        parts.append(_part(capsule(0.055, 0.07, 0.46, "Z"), (0.02, side * 0.27, 1.08), RED))
        parts.append(_part(capsule(0.07, 0.095, 0.68, "Z"), (0, side * 0.10, 0.48), _DARK_RED))
        parts.append(_part(capsule(0.06, 0.06, 0.12, "X"), (0.06, side * 0.10, 0.06), _HAIR))
    scale = np.diag([height_m / _FULL_HEIGHT_M] * 3 + [1.0])
    return [placed(part, scale[None]) for part in parts]


def trail_meshes(feet: FloatArray, radius_m: float) -> list[SceneMesh]:
    """Return a line through the (k, 3) feet, metres, with a ball wherever the agent stood."""
    line = feet + np.array([0.0, 0.0, radius_m])
    if not len(line):
        return []
    shifts = np.tile(np.eye(4), (len(line), 1, 1))
    shifts[:, 3, :3] = line
    balls = [placed(_part(sphere(radius_m * 1.8), (0, 0, 0), TRAIL), shifts)]
    return balls + [_rod(a, b, radius_m) for a, b in zip(line[:-1], line[1:], strict=True) if (a != b).any()]


def _rod(start: FloatArray, end: FloatArray, radius_m: float) -> SceneMesh:
    along = end - start
    length = float(np.linalg.norm(along))
    ahead = along / length
    side = np.cross(ahead, np.eye(3)[int(np.argmin(np.abs(ahead)))])
    side /= np.linalg.norm(side)
    matrix = np.eye(4)
    matrix[:3, :3] = [side, np.cross(ahead, side), ahead]
    matrix[3, :3] = (start + end) / 2
    return placed(_part(cylinder(radius_m, radius_m, length, "Z"), (0, 0, 0), TRAIL), matrix[None])


def _part(shape: Topology, centre: Sequence[float], colour: Colour) -> SceneMesh:
    points = shape.points[shape.triangles].reshape(-1, 3) + np.array(centre)
    return SceneMesh(
        path="/Agent",
        points=points,
        triangles=np.arange(len(points)).reshape(-1, 3),
        normals=corner_normals(shape.points, shape.triangles).reshape(-1, 3),
        colour=colour,
    )
