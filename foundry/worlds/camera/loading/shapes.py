"""The primitive shapes of USD as triangles around their own origin, as their schemas define them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from foundry.worlds.camera.loading.scene import FloatArray, IntArray
from foundry.worlds.camera.loading.topology import Topology, triangulated

AROUND = 32
"""Sides of round shapes: below the angle at which normals are split, so that they look round."""

_TURNS: Mapping[str, tuple[int, int, int]] = MappingProxyType({"X": (2, 0, 1), "Y": (1, 2, 0), "Z": (0, 1, 2)})
"""Which coordinate of a shape made along Z becomes x, y and z."""

AXES = tuple(_TURNS)
"""The axes that a shape can have."""


def _polygons(points: FloatArray, faces: list[list[int]], axis: str = "Z") -> Topology:
    counts = np.array([len(face) for face in faces], np.int64)
    indices = np.array([corner for face in faces for corner in face], np.int64)
    return triangulated(points[:, _TURNS[axis]], counts, indices, np.zeros(0, np.int64))


@lru_cache(maxsize=64)
def box(size: float) -> Topology:
    """Return a cube of this edge length."""
    points = (np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]) - 0.5) * size
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return _polygons(points, faces)


def turned(profile: FloatArray, axis: str = "Z") -> Topology:
    """Turn a (k, 2) profile of (radius, height), from the bottom up, around an axis; ends of radius 0 close it."""
    angles = np.arange(AROUND) * (2 * np.pi / AROUND)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    radii, heights = profile.T
    points = np.concatenate(
        [np.repeat(radii, AROUND)[:, None] * np.tile(ring, (len(profile), 1)), np.repeat(heights, AROUND)[:, None]],
        axis=1,
    )
    rows = np.arange(len(profile))[:, None] * AROUND
    ids: IntArray = np.where(radii[:, None] == 0, rows, rows + np.arange(AROUND))
    faces = []
    for low, high in zip(ids[:-1], ids[1:], strict=True):
        for i in range(AROUND):
            j = (i + 1) % AROUND
            faces.append(list(dict.fromkeys([int(low[i]), int(low[j]), int(high[j]), int(high[i])])))
    return _polygons(points, faces, axis)


def _arc(radius: float, centre: float, start: float, end: float) -> FloatArray:
    """Return part of a circle as a profile; angles in degrees, -90 at the bottom."""
    angles = np.radians(np.linspace(start, end, 1 + round(AROUND * abs(end - start) / 360)))
    points = np.stack([radius * np.cos(angles), centre + radius * np.sin(angles)], axis=1)
    points[np.abs(np.cos(angles)) < 1e-9, 0] = 0
    return points


@lru_cache(maxsize=64)
def sphere(radius: float) -> Topology:
    """Return a sphere."""
    return turned(_arc(radius, 0, -90, 90))


@lru_cache(maxsize=64)
def cylinder(bottom: float, top: float, height: float, axis: str) -> Topology:
    """Return a closed cylinder with these radii at its two ends; a cone when one of them is 0."""
    half = height / 2
    return turned(np.array([[0, -half], [bottom, -half], [top, half], [0, half]]), axis)


@lru_cache(maxsize=64)
def capsule(bottom: float, top: float, height: float, axis: str) -> Topology:
    """Return a cylinder of this height between two half spheres."""
    half = height / 2
    return turned(np.concatenate([_arc(bottom, -half, -90, 0), _arc(top, half, 0, 90)]), axis)


def plane(width: float, length: float, axis: str) -> Topology:
    """Return a rectangle whose normal is the axis: width along x (z when the axis is X), length along y (z when Y)."""
    u, v = {"X": (2, 1), "Y": (0, 2), "Z": (0, 1)}[axis]
    points = np.zeros((4, 3))
    points[:, u] = np.array([-1, 1, 1, -1]) * width / 2
    points[:, v] = np.array([-1, -1, 1, 1]) * length / 2
    order = [0, 1, 2, 3] if axis == "Z" else [3, 2, 1, 0]
    return _polygons(points, [order])


Size = Callable[[str], float]
"""Gives the value of a shape's attribute by its name."""

Axis = Callable[[], str]
"""Gives the axis of a shape."""

SHAPES: Mapping[str, Callable[[Size, Axis], Topology]] = MappingProxyType(
    {
        "Cube": lambda size, axis: box(size("size")),
        "Sphere": lambda size, axis: sphere(size("radius")),
        "Cylinder": lambda size, axis: cylinder(size("radius"), size("radius"), size("height"), axis()),
        "Cylinder_1": lambda size, axis: cylinder(size("radiusBottom"), size("radiusTop"), size("height"), axis()),
        "Cone": lambda size, axis: cylinder(size("radius"), 0.0, size("height"), axis()),
        "Capsule": lambda size, axis: capsule(size("radius"), size("radius"), size("height"), axis()),
        "Capsule_1": lambda size, axis: capsule(size("radiusBottom"), size("radiusTop"), size("height"), axis()),
        "Plane": lambda size, axis: plane(size("width"), size("length"), axis()),
    }
)
"""How each primitive of UsdGeom is made."""
