"""Things in a scene that an agent is to find: how near they are, and whether they can be seen."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial import KDTree
from vtkmodules.vtkCommonCore import reference
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

from foundry.worlds.camera.body.outlines import BoolArray, cut, dotted, nearest_offsets
from foundry.worlds.camera.body.surfaces import Surfaces
from foundry.worlds.camera.loading.polydata import polydata
from foundry.worlds.camera.loading.scene import FloatArray, IntArray, Scene

SEE_THROUGH = 0.5
"""Opacity below which a surface hides nothing."""

SAMPLES = 64
"""Points of a target that are looked for."""

FLUSH_M = 5e-3
"""What is hit this close to a point of the target does not hide it: a picture lies flush with its wall."""


class TargetSurfaces:
    """The surfaces of some prims.

    Args:
        surfaces: of the scene.
        prims: paths of the prims; everything below them belongs to the target.
    """

    def __init__(self, surfaces: Surfaces, prims: Iterable[str]) -> None:
        self.meshes = surfaces.meshes_under(prims)
        self._surfaces = surfaces
        self._triangles = np.flatnonzero(np.isin(surfaces.mesh, self.meshes))
        corners = surfaces.corners[self._triangles]
        self._outlines = cut(corners, -np.inf, np.inf)
        self.points = _spread(corners)
        self.box: FloatArray = np.array([corners.min(axis=(0, 1)), corners.max(axis=(0, 1))])

    def gap(self, foot: FloatArray) -> float:
        """Return the distance from the axis over `foot` (3,) to the closest point of the target, seen from above."""
        if not np.isnan(self._surfaces.heights(foot[None, :2], self._triangles)).all():
            return 0.0
        return float(np.hypot(*nearest_offsets(foot[:2], self._outlines.ends).T).min())

    def is_near(self, places: FloatArray, radius_m: float) -> BoolArray:
        """Return which of (n, 3) places have a gap of at most a radius."""
        result = np.asarray(KDTree(dotted(self._outlines)).query(places[:, :2])[0] <= radius_m)
        corners = self._surfaces.corners[self._triangles, :, :2]
        # Only above or below a triangle this large can a place be far from all outlines.
        large = self._triangles[(np.ptp(corners, axis=1) > radius_m).all(axis=1)]
        for place in np.flatnonzero(~result) if large.size else ():
            result[place] = not np.isnan(self._surfaces.heights(places[place : place + 1, :2], large)).all()
        return result


class SightLines:
    """Straight lines of sight in a scene; glass hides nothing.

    Args:
        scene: where.
        surfaces: of the scene.
    """

    def __init__(self, scene: Scene, surfaces: Surfaces) -> None:
        clear = np.array([mesh.opacity < SEE_THROUGH for mesh in scene.meshes])
        self._opaque: IntArray = np.flatnonzero(~clear[surfaces.mesh])
        self._surfaces = surfaces
        self._answers: tuple[Any, Any, Any] = reference(0.0), reference(0), reference(0)

    @cached_property
    def _locator(self) -> Any:
        corners = self._surfaces.corners[self._opaque]
        locator = vtkStaticCellLocator()
        locator.SetDataSet(polydata(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)))
        locator.BuildLocator()
        return locator

    def reaches(self, eye: FloatArray, target: TargetSurfaces) -> bool:
        """Return whether anything of the target can be seen from `eye` (3,), in whatever direction it lies."""
        if not self._opaque.size:
            return True
        origin = eye.tolist()
        return any(self._meets(origin, point, target) for point in target.points.tolist())

    def points_seen(self, eye: FloatArray, target: TargetSurfaces) -> FloatArray:
        """Return those of the target's points, (k, 3), that nothing hides from `eye` (3,), in whatever direction."""
        origin = eye.tolist()
        seen = [not self._opaque.size or self._meets(origin, point, target) for point in target.points.tolist()]
        return np.asarray(target.points[seen])

    def _meets(self, eye: list[float], point: list[float], target: TargetSurfaces) -> bool:
        part, cell, piece = self._answers
        if not self._locator.IntersectWithLine(eye, point, 1e-9, part, [0.0] * 3, [0.0] * 3, piece, cell):
            return True
        left = (1.0 - part.get()) * math.dist(eye, point)
        return left < FLUSH_M or int(self._surfaces.mesh[self._opaque[cell.get()]]) in target.meshes


def _spread(corners: FloatArray) -> FloatArray:
    """Return (k, 3) points spread evenly over the area of (n, 3, 3) triangles, always the same ones."""
    sides = corners[:, 1:] - corners[:, :1]
    area = np.cumsum(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1))
    number = np.arange(SAMPLES)
    chosen = np.searchsorted(area, (number + 0.5) / SAMPLES * area[-1])
    # Multiples of two roots of x^3 = x + 1 fill the unit square evenly.
    u, v = (number * 0.7548776662466927) % 1, (number * 0.5698402909980532) % 1
    folded = u + v > 1
    u, v = np.where(folded, 1 - u, u), np.where(folded, 1 - v, v)
    first, second = sides[chosen].transpose(1, 0, 2)
    points: FloatArray = corners[chosen, 0] + u[:, None] * first + v[:, None] * second
    return points
