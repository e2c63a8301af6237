"""Small synthetic scenes of quads and boxes."""

import hashlib
from itertools import pairwise

import numpy as np

from foundry.worlds.camera.loading.scene import Scene, SceneMesh

TWO_TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


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


def enclosed(*things: SceneMesh) -> Scene:
    """Return a floor of 6 x 6 m around the origin with a wall at each side, and things on it."""
    corners = [(-3, -3), (3, -3), (3, 3), (-3, 3), (-3, -3)]
    walls = [wall(a, b, path=f"/side_{number}") for number, (a, b) in enumerate(pairwise(corners))]
    return scene(floor(-3, -3, 3, 3), *walls, *things)
