"""All triangles of a scene in one array, found by where they lie in the plane."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from foundry.errors import InputError, not_found
from foundry.worlds.camera.loading.scene import FloatArray, IntArray, Scene

BUCKET_M = 0.25
"""Edge of a square of the index; larger in scenes so large that the index would hold too many."""

MAX_BUCKETS = 400
"""Squares of the index along its longer side, at most."""

FLOOR_NORMAL = 0.01
"""Upward part of a unit normal below which a triangle is too steep to have a height."""


class Surfaces:
    """The triangles of a scene; both of their sides count, whatever their winding.

    Attributes:
        corners: (n, 3, 3) metres, [triangle, corner, axis].
        mesh: (n,) index into the scene's meshes.
        names: what to call the mesh of each index: its label, else its path.
    """

    def __init__(self, scene: Scene) -> None:
        if not any(len(mesh.triangles) for mesh in scene.meshes):
            raise InputError(f"Scene '{scene.name}' has no surface to stand on or to run into. Check its `exclude`.")
        corners = np.concatenate([mesh.points[mesh.triangles] for mesh in scene.meshes]).astype(np.float64)
        owners = np.repeat(np.arange(len(scene.meshes)), [len(mesh.triangles) for mesh in scene.meshes])
        sound = np.isfinite(corners).all(axis=(1, 2))
        self.corners: FloatArray = corners[sound]
        self.mesh: IntArray = owners[sound]
        self.names = tuple(mesh.label or mesh.path for mesh in scene.meshes)
        self._paths = tuple(mesh.path for mesh in scene.meshes)
        self._low, self._high = self.corners.min(axis=1), self.corners.max(axis=1)
        self._ends = np.concatenate([self._low, -self._high], axis=1)
        self._inverse = _barycentric(self.corners)
        self._is_flat = ~np.isnan(self._inverse[:, 0, 0])
        self._build_index()

    def _build_index(self) -> None:
        self._origin = self._low[:, :2].min(axis=0)
        extent = self._high[:, :2].max(axis=0) - self._origin
        self._bucket = max(BUCKET_M, float(extent.max()) / MAX_BUCKETS)
        self._shape = (extent // self._bucket).astype(np.int64) + 1
        triangles, column, row = cells_of(self._square(self._low[:, :2]), self._square(self._high[:, :2]))
        squares = row * self._shape[0] + column
        order = np.argsort(squares, kind="stable")
        self._sorted: IntArray = triangles[order]
        self._starts = np.searchsorted(squares[order], np.arange(self._shape.prod() + 1))

    def _square(self, points: FloatArray) -> IntArray:
        squares = np.floor((points - self._origin) / self._bucket).astype(np.int64)
        return np.asarray(np.clip(squares, 0, self._shape - 1))

    def near(self, low: FloatArray, high: FloatArray) -> IntArray:
        """Return the triangles whose boxes overlap the one from `low` (3,) to `high` (3,), ascending."""
        (x0, y0), (x1, y1) = self._square(low[:2]), self._square(high[:2])
        rows = np.arange(y0, y1 + 1) * self._shape[0]
        spans = zip(self._starts[rows + x0], self._starts[rows + x1 + 1], strict=True)
        found = np.concatenate([self._sorted[start:stop] for start, stop in spans])
        return np.unique(self.overlapping(found, low, high))

    def overlapping(self, triangles: IntArray, low: FloatArray, high: FloatArray) -> IntArray:
        """Return those of the triangles whose boxes overlap the one from `low` (3,) to `high` (3,)."""
        overlaps = (self._ends[triangles] <= np.concatenate([high, -low])).all(axis=1)
        return np.asarray(triangles[overlaps])

    def flat(self, triangles: IntArray) -> IntArray:
        """Return those of the triangles that are flat enough to have one height at a place."""
        return np.asarray(triangles[self._is_flat[triangles]])

    def heights(self, points: FloatArray, triangles: IntArray) -> FloatArray:
        """Return the (k, m) height at which each of (m,) triangles meets the vertical through each of (k, 2) points.

        NaN where it does not, or is too steep to have one height.
        """
        corners = self.corners[triangles]
        return _heights(points[:, None] - corners[:, 0, :2], corners, self._inverse[triangles])

    def columns(self, low: IntArray, high: IntArray, cell_m: float) -> tuple[IntArray, IntArray, FloatArray]:
        """Return column, row and height of every crossing of a triangle with the centre line of a cell.

        Cell (i, j) has its centre at ((i + 0.5) cell_m, (j + 0.5) cell_m); only those from `low` (2,) to
        `high` (2,), both included, are looked at.
        """
        able = np.flatnonzero(self._is_flat)
        first = np.maximum(np.ceil(self._low[able, :2] / cell_m - 0.5 - 1e-9).astype(np.int64), low)
        last = np.minimum(np.floor(self._high[able, :2] / cell_m - 0.5 + 1e-9).astype(np.int64), high)
        owner, column, row = cells_of(first, last)
        triangles = able[owner]
        corners = self.corners[triangles]
        centres = (np.column_stack([column, row]) + 0.5) * cell_m
        heights = _heights(centres - corners[:, 0, :2], corners, self._inverse[triangles])
        inside = ~np.isnan(heights)
        return column[inside], row[inside], heights[inside]

    def meshes_under(self, prims: Iterable[str]) -> IntArray:
        """Return the indices of the meshes that are one of the prims or lie below one, ascending."""
        found: set[int] = set()
        for prim in prims:
            below = prim.rstrip("/") + "/"
            matches = {i for i, path in enumerate(self._paths) if path == prim or path.startswith(below)}
            if not matches:
                raise not_found("Prim", prim, self._paths, "Only prims with a surface can be targets.")
            found |= matches
        return np.array(sorted(found), np.int64)


def cells_of(first: IntArray, last: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return owner, column and row of every cell of the boxes `first` (n, 2) to `last` (n, 2), both included."""
    width, depth = np.maximum(last - first + 1, 0).T
    counts = width * depth
    owner = np.repeat(np.arange(len(first)), counts)
    within = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owner, first[owner, 0] + within % width[owner], first[owner, 1] + within // width[owner]


def _barycentric(corners: FloatArray) -> FloatArray:
    """Return (n, 2, 2) maps from offsets in the plane to barycentric coordinates; NaN for steep triangles."""
    sides = corners[:, 1:] - corners[:, :1]
    normals = np.cross(sides[:, 0], sides[:, 1])
    area = np.linalg.norm(normals, axis=1)
    usable = (np.abs(normals[:, 2]) > FLOOR_NORMAL * area) & (area > 0)
    determinant = np.where(usable, normals[:, 2], np.nan)
    (ux, uy), (vx, vy) = sides[:, 0, :2].T, sides[:, 1, :2].T
    inverse = np.array([[vy, -vx], [-uy, ux]]).transpose(2, 0, 1)
    return np.asarray(inverse / determinant[:, None, None])


def _heights(offsets: FloatArray, corners: FloatArray, inverse: FloatArray) -> FloatArray:
    """Return the (...) heights at (..., 2) offsets from the first corner; NaN outside of the triangle."""
    x, y = offsets[..., 0], offsets[..., 1]
    u = x * inverse[:, 0, 0] + y * inverse[:, 0, 1]
    v = x * inverse[:, 1, 0] + y * inverse[:, 1, 1]
    z = corners[:, :, 2]
    heights = z[:, 0] + u * (z[:, 1] - z[:, 0]) + v * (z[:, 2] - z[:, 0])
    inside = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9)
    return np.where(inside, heights, np.nan)
