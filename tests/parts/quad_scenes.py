"""Small synthetic scenes of quads and boxes, and a check of room that shares no code with the collider."""

from __future__ import annotations

import hashlib
from itertools import pairwise

import numpy as np

from foundry.worlds.camera.body.size import Body
from foundry.worlds.camera.loading.scene import FloatArray, Scene, SceneMesh

TWO_TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
SAMPLE_M = 0.03


def quad(path: str, corners: list[list[float]], *, flipped: bool = False, opacity: float = 1.0) -> SceneMesh:
    triangles = TWO_TRIANGLES[:, ::-1] if flipped else TWO_TRIANGLES
    return SceneMesh(path, np.array(corners, np.float64), triangles, opacity=opacity)


def floor(x0: float, y0: float, x1: float, y1: float, z: float = 0.0, path: str = "/floor") -> SceneMesh:
    return quad(path, [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])


def wall(
    start: tuple[float, float],
    end: tuple[float, float],
    low: float = 0.0,
    high: float = 2.5,
    path: str = "/wall",
    *,
    flipped: bool = False,
    opacity: float = 1.0,
) -> SceneMesh:
    corners = [[*start, low], [*end, low], [*end, high], [*start, high]]
    return quad(path, corners, flipped=flipped, opacity=opacity)


def box(path: str, low: tuple[float, float, float], high: tuple[float, float, float]) -> SceneMesh:
    (x0, y0, z0), (x1, y1, z1) = low, high
    points = [[x, y, z] for z in (z0, z1) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
    faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    triangles = [triangle for a, b, c, d in faces for triangle in ((a, b, c), (a, c, d))]
    return SceneMesh(path, np.array(points, np.float64), np.array(triangles))


def scene(*meshes: SceneMesh, name: str = "synthetic") -> Scene:
    points = np.concatenate([mesh.points for mesh in meshes])
    return Scene(
        name=name,
        source=name,
        sha256=hashlib.sha256(points.tobytes()).hexdigest(),
        meshes=meshes,
        bounds=np.array([points.min(axis=0), points.max(axis=0)]),
        labels={},
        warnings=(),
        up_axis="Z",
        metres_per_unit=1.0,
        prims=len(meshes),
        triangles=sum(len(mesh.triangles) for mesh in meshes),
    )


def sampled(place: Scene, spacing: float = SAMPLE_M) -> FloatArray:
    """Return (n, 3) points all over the surfaces, a spacing apart."""
    points = []
    for mesh in place.meshes:
        for a, b, c in mesh.points[mesh.triangles]:
            steps = max(int(np.ceil(max(np.linalg.norm(b - a), np.linalg.norm(c - a)) / spacing)), 1)
            u, v = np.meshgrid(np.linspace(0, 1, steps + 1), np.linspace(0, 1, steps + 1))
            u, v = u[u + v <= 1 + 1e-9], v[u + v <= 1 + 1e-9]
            points.append(a + u[:, None] * (b - a) + v[:, None] * (c - a))
    return np.concatenate(points)


def closest(surface: FloatArray, track: FloatArray, body: Body) -> float:
    """Return how near the axis of the capsule comes to (n, 3) points above its step height, metres."""
    low, high = track.min(axis=0) - body.radius_m, track.max(axis=0) + body.height_m
    surface = surface[((surface >= low) & (surface <= np.append(high[:2] + body.radius_m, high[2]))).all(axis=1)]
    places = [np.linspace(a, b, max(int(np.linalg.norm(b - a) / 0.05), 1) + 1) for a, b in pairwise(track)]
    nearest = np.inf
    for foot in np.concatenate([track[-1:], *places]):
        able = surface[surface[:, 2] > foot[2] + body.step_m + 0.002]
        low_end, high_end = foot[2] + body.radius_m, foot[2] + body.height_m - body.radius_m
        axis = np.clip(able[:, 2], low_end, max(low_end, high_end))
        gaps = np.sqrt(((able[:, :2] - foot[:2]) ** 2).sum(axis=1) + (able[:, 2] - axis) ** 2)
        nearest = min(nearest, gaps.min(initial=np.inf))
    return float(nearest)
