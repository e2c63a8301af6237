"""What carries a body and what leaves it room, at a place."""

from __future__ import annotations

import math

import numpy as np

from foundry.worlds.camera.body.outlines import cut, nearest_offsets
from foundry.worlds.camera.body.size import Body
from foundry.worlds.camera.body.surfaces import Surfaces
from foundry.worlds.camera.loading.scene import FloatArray, IntArray, Scene

REACH_M = 1e-3
"""How far beyond the body's radius surfaces are looked at, metres."""

_RING = np.array([[math.cos(turn), math.sin(turn)] for turn in np.arange(8) * math.tau / 8])


class Ground:
    """The surfaces of a scene as floors and obstacles.

    Args:
        scene: where.
        floor_height: height of the foot everywhere, metres; None: that of the surface below it.
    """

    def __init__(self, scene: Scene, floor_height: float | None) -> None:
        self.surfaces = Surfaces(scene)
        self.floor_height = floor_height

    def near(self, points: FloatArray, body: Body) -> IntArray:
        """Return the triangles beside the ways among (k, 2) points, at any height."""
        return self.surfaces.near(*_box(points, body, (-math.inf, math.inf)))

    def obstacles(self, points: FloatArray, foot_z: float, near: IntArray, body: Body) -> IntArray:
        """Return those triangles that can stop a body among (k, 2) points with its foot at a height."""
        return self.surfaces.overlapping(near, *_box(points, body, body.span(foot_z)))

    def profile(self, points: FloatArray, foot_z: float, near: IntArray, body: Body) -> FloatArray:
        """Return the height of the foot at each of (k, 2) points in turn, up to where the floor ends.

        Args:
            points: places on the way, metres.
            foot_z: height of the foot before the first, metres.
            near: the triangles around the way.
            body: who walks.
        """
        if self.floor_height is not None:
            return np.full(len(points), self.floor_height)
        flat = self.surfaces.flat(near)
        heights = self.surfaces.heights(points, flat)
        found: list[float] = []
        for point, column in zip(points, heights, strict=True):
            floor = _highest(column, body.stride(foot_z))
            if floor is None:
                floor = self._bridge(point, foot_z, flat, body)
            if floor is None:
                break
            found.append(foot_z := floor)
        return np.array(found)

    def _bridge(self, point: FloatArray, foot_z: float, near: IntArray, body: Body) -> float | None:
        """Return the height of the floor on both sides of a gap narrower than the radius, or None."""
        ring = self.surfaces.heights(point + body.radius_m * _RING, near)
        floors = [_highest(column, body.stride(foot_z)) for column in ring]
        pairs = zip(floors[:4], floors[4:], strict=True)
        return max((min(a, b) for a, b in pairs if a is not None and b is not None), default=None)

    def below(self, place: FloatArray, body: Body) -> float | None:
        """Return the height on which a foot at or above `place` (3,) comes to stand, or None over nothing."""
        if self.floor_height is not None:
            return self.floor_height
        near = self.near(place[None, :2], body)
        return _highest(self.surfaces.heights(place[None, :2], near)[0], (-math.inf, body.stride(float(place[2]))[1]))

    def clearance(self, foot: FloatArray, near: IntArray, body: Body) -> tuple[float, int]:
        """Return the distance in the plane (metres) from the body's axis to the nearest obstacle, and its triangle.

        Only obstacles within reach count: the distance is inf, and the triangle -1, if there is none.
        """
        low, high = body.span(float(foot[2]))
        able = self.obstacles(foot[None, :2], float(foot[2]), near, body)
        flat = self.surfaces.flat(able)
        heights = self.surfaces.heights(foot[None, :2], flat)[0]
        crossing = np.flatnonzero((heights >= low) & (heights <= high))
        if crossing.size:
            return 0.0, int(flat[crossing[0]])
        outlines = cut(self.surfaces.corners[able], low, high)
        if not outlines.owner.size:
            return math.inf, -1
        gaps = np.hypot(*nearest_offsets(foot[:2], outlines.ends).T)
        first = int(np.argmin(gaps))
        return float(gaps[first]), int(able[outlines.owner[first]])

    def name(self, triangle: int) -> str:
        """Return what to call the mesh that a triangle belongs to."""
        return self.surfaces.names[int(self.surfaces.mesh[triangle])]


def _box(points: FloatArray, body: Body, heights: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    reach = body.radius_m + REACH_M
    low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
    return np.append(low, heights[0]), np.append(high, heights[1])


def _highest(heights: FloatArray, window: tuple[float, float]) -> float | None:
    inside = heights[(heights >= window[0]) & (heights <= window[1])]
    return float(inside.max()) if inside.size else None
