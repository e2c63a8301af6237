"""Faces to triangles: n-gons, concave ones too, without losing which corner of which face each came from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from foundry.worlds.camera.loading.scene import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Topology:
    """The triangles of one prim in its own space.

    Attributes:
        points: (n, 3).
        triangles: (m, 3) indices of points.
        corners: (m, 3) indices of face-vertices, for face-varying data.
        faces: (m,) the face each triangle came from.
    """

    points: FloatArray
    triangles: IntArray
    corners: IntArray
    faces: IntArray

    def flipped(self) -> Topology:
        """Return the same triangles seen from the other side."""
        return Topology(self.points, self.triangles[:, ::-1], self.corners[:, ::-1], self.faces)


def triangulated(points: FloatArray, counts: IntArray, indices: IntArray, holes: IntArray) -> Topology:
    """Cut faces into triangles; faces of fewer than three corners and those named in `holes` are left out.

    Args:
        points: (n, 3).
        counts: (f,) corners of each face.
        indices: (sum of counts,) the point of each corner, face after face.
        holes: (h,) faces that are not there.
    """
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    drawn = counts >= 3
    drawn[holes[(holes >= 0) & (holes < len(counts))]] = False
    corners, faces = [], []
    for size in np.unique(counts[drawn]):
        which = np.flatnonzero(drawn & (counts == size))
        polygons = starts[which][:, None] + np.arange(size)
        cut = _cut(points[indices[polygons]])
        corners.append(np.take_along_axis(polygons[:, None, :], cut, axis=2).reshape(-1, 3))
        faces.append(np.repeat(which, size - 2))
    all_corners = np.concatenate(corners) if corners else np.zeros((0, 3), np.int64)
    all_faces = np.concatenate(faces) if faces else np.zeros(0, np.int64)
    order = np.argsort(all_faces, kind="stable")
    return Topology(points, indices[all_corners[order]], all_corners[order], all_faces[order])


def _cut(polygons: FloatArray) -> IntArray:
    """Return (f, s - 2, 3) positions within each of the (f, s, 3) polygons."""
    count, size = polygons.shape[:2]
    normals = np.cross(polygons, np.roll(polygons, -1, axis=1)).sum(axis=1)
    cut = np.zeros((count, size - 2, 3), np.int64)
    open_ones = np.arange(count)
    for first in range(min(size, 2) if size > 3 else 1):
        fan = _fan(size, first)
        good = _is_sound(polygons[open_ones], normals[open_ones], fan)
        cut[open_ones if first == 0 else open_ones[good]] = fan
        open_ones = open_ones[~good]
    if size > 4:
        for face in open_ones:
            cut[face] = _ears(polygons[face], normals[face])
    return cut


def _fan(size: int, first: int) -> IntArray:
    rest = (first + 1 + np.arange(size - 1)) % size
    return np.stack([np.full(size - 2, first), rest[:-1], rest[1:]], axis=1)


def _is_sound(polygons: FloatArray, normals: FloatArray, fan: IntArray) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return for which polygons every triangle of the fan faces the way the polygon does."""
    a, b, c = (polygons[:, fan[:, i]] for i in range(3))
    facing = np.einsum("fti,fi->ft", np.cross(b - a, c - a), normals)
    return np.asarray((facing >= 0).all(axis=1))


def _ears(polygon: FloatArray, normal: FloatArray) -> IntArray:
    """Cut one (s, 3) polygon ear by ear; where it crosses itself the rest is cut as it comes."""
    flat = np.delete(polygon, np.argmax(np.abs(normal)), axis=1)
    ring = list(range(len(polygon)))
    turn = np.sign(_area(flat))
    triangles = []
    while len(ring) > 3:
        ear = next((i for i in range(len(ring)) if _is_ear(flat, ring, i, turn)), 0)
        triangles.append((ring[ear - 1], ring[ear], ring[(ear + 1) % len(ring)]))
        del ring[ear]
    return np.array([*triangles, ring], np.int64)


def _area(flat: FloatArray) -> float:
    x, y = flat.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def _is_ear(flat: FloatArray, ring: list[int], at: int, turn: float) -> bool:
    triangle = flat[[ring[at - 1], ring[at], ring[(at + 1) % len(ring)]]]
    if turn * _area(triangle) <= 0:
        return False
    corners = {tuple(corner) for corner in triangle}
    others = np.array([flat[i] for i in ring if tuple(flat[i]) not in corners]).reshape(-1, 2)
    edges = np.roll(triangle, -1, axis=0) - triangle
    to_point = others[:, None, :] - triangle[None]
    sides = turn * (edges[:, 0] * to_point[..., 1] - edges[:, 1] * to_point[..., 0])
    return not bool((sides >= 0).all(axis=1).any())
