"""Shortest paths over the floors of a scene, on a grid that is built once and cached on disk."""

import hashlib
import heapq
import json
import math
import zipfile
import zlib
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any

import numpy as np
from numpy.random import Generator
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import KDTree
from vtkmodules.vtkCommonCore import reference
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

from foundry.errors import InputError
from foundry.worlds.camera.body.collision import Body, Collider
from foundry.worlds.camera.body.surfaces import BoolArray, Surfaces, cut, dotted, nearest_offsets
from foundry.worlds.camera.body.walkable import Route, Walkable, direct, find_walkable
from foundry.worlds.camera.loading.meshes import polydata
from foundry.worlds.camera.loading.scene import FloatArray, IntArray, Scene

SEE_THROUGH = 0.5
"""Opacity below which one can see through a surface."""

SAMPLES = 64
"""Number of points on a target's surface to which lines of sight are tested."""

FLUSH_M = 5e-3
"""A surface within this distance of a point of the target, metres, does not hide it: a poster touches its wall."""


class TargetSurfaces:
    """The surfaces of a target.

    Args:
        prims: paths of the target's prims; everything below them belongs to the target.

    Attributes:
        points: (k, 3) points spread over the surfaces, metres.
        box: (2, 3) lowest and highest corner, metres.
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
        """Return the horizontal distance from `foot` (3,) to the closest point of the target, metres."""
        if not np.isnan(self._surfaces.heights(foot[None, :2], self._triangles)).all():
            return 0.0
        return float(np.hypot(*nearest_offsets(foot[:2], self._outlines.ends).T).min())

    def is_near(self, places: FloatArray, radius_m: float) -> BoolArray:
        """Return, for n places (n, 3), whether the target is within the radius of the place, seen from above, (n,)."""
        result = np.asarray(KDTree(dotted(self._outlines)).query(places[:, :2])[0] <= radius_m)
        corners = self._surfaces.corners[self._triangles, :, :2]
        # A place that is far from all outlines can still be above or below a triangle as large as this.
        large = self._triangles[(np.ptp(corners, axis=1) > radius_m).all(axis=1)]
        for place in np.flatnonzero(~result) if large.size else ():
            result[place] = not np.isnan(self._surfaces.heights(places[place : place + 1, :2], large)).all()
        return result


class SightLines:
    """Tells which straight lines of sight in a scene are free; transparent surfaces hide nothing."""

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
        """Return whether at least one straight line from `eye` (3,) to a point of the target meets no obstacle."""
        return any(self._meets(eye.tolist(), point, target) for point in target.points.tolist())

    def points_seen(self, eye: FloatArray, target: TargetSurfaces) -> FloatArray:
        """Return the points (k, 3) of the target whose straight line to `eye` (3,) meets no obstacle."""
        seen = [self._meets(eye.tolist(), point, target) for point in target.points.tolist()]
        return np.asarray(target.points[seen])

    def _meets(self, eye: list[float], point: list[float], target: TargetSurfaces) -> bool:
        if not self._opaque.size:
            return True
        part, cell, piece = self._answers
        if not self._locator.IntersectWithLine(eye, point, 1e-9, part, [0.0] * 3, [0.0] * 3, piece, cell):
            return True
        left = (1.0 - part.get()) * math.dist(eye, point)
        return left < FLUSH_M or int(self._surfaces.mesh[self._opaque[cell.get()]]) in target.meshes


def _spread(corners: FloatArray) -> FloatArray:
    """Return points (k, 3), spread evenly over the area of (n, 3, 3) triangles, without chance."""
    sides = corners[:, 1:] - corners[:, :1]
    area = np.cumsum(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1))
    number = np.arange(SAMPLES)
    chosen = np.searchsorted(area, (number + 0.5) / SAMPLES * area[-1])
    # Multiples of two powers of the root of x^3 = x + 1 fill the unit square evenly.
    u, v = (number * 0.7548776662466927) % 1, (number * 0.5698402909980532) % 1
    folded = u + v > 1
    u, v = np.where(folded, 1 - u, u), np.where(folded, 1 - v, v)
    first, second = sides[chosen].transpose(1, 0, 2)
    points: FloatArray = corners[chosen, 0] + u[:, None] * first + v[:, None] * second
    return points


STRIDE_M = 0.5
"""Length of each move with which a body tries to leave a narrow place, metres."""

TURNS_DEG = tuple(range(0, 360, 45))
"""Directions of the moves by which a body searches for a way out; walls deflect the moves."""

MOST_PLACES = 100
"""Largest number of places that the search for a way out tries."""


@dataclass(frozen=True, eq=False)
class Approach:
    """The first part of a path: from a body's foot to cells of the navigation grid.

    Attributes:
        track: (k, 3) places on the path, the foot first.
        cells: (n,) the cells around the last place, the nearest first.
        gaps: (n,) length of the path to each of these cells, seen from above, metres.
    """

    track: FloatArray
    cells: IntArray
    gaps: FloatArray


class Approaches:
    """Finds paths from any place to the nearest cells; `places` (n, 3) are the centres of all cells, metres."""

    def __init__(self, collider: Collider, body: Body, places: FloatArray, cell_m: float) -> None:
        self._collider, self._body, self._places, self._cell_m = collider, body, places, cell_m
        self._tree: Any = KDTree(places)
        self._latest: tuple[bytes, Approach] | None = None

    def find(self, foot: FloatArray) -> Approach:
        """Return the first part of a path, from `foot` (3,) to cells of the grid; the latest result is cached."""
        key = np.asarray(foot, np.float64).tobytes()
        if self._latest is None or self._latest[0] != key:
            self._latest = (key, self._find(foot))
        return self._latest[1]

    def within(self, track: FloatArray, reach_m: float) -> IntArray:
        """Return the ascending indices of the cells that contain one of k places (k, 3), or are near one."""
        nearby = self._tree.query_ball_point(track, max(reach_m, 0.71 * self._cell_m))
        return np.unique(np.array([cell for cells in nearby for cell in cells], np.int64))

    def _find(self, foot: FloatArray) -> Approach:
        near = self._around(foot)
        if self._is_open(near):
            return near
        out = self._way_out(foot)
        # If the way out leads to a nearby cell, the cell is only round a corner.
        return near if out is None or np.isin(near.cells, out.cells).any() else out

    def _around(self, foot: FloatArray) -> Approach:
        reach = max(2 * self._body.radius_m, 5 * self._cell_m)
        gaps, cells = self._tree.query(foot, k=9, distance_upper_bound=reach)
        # Cells much farther than the nearest one may be on the other side of a wall.
        near = gaps <= gaps[0] + self._cell_m if np.isfinite(gaps[0]) else np.zeros(len(gaps), np.bool_)
        cells = cells[near].astype(np.int64)
        return Approach(foot[None], cells, np.hypot(*(self._places[cells] - foot)[:, :2].T))

    def _is_open(self, approach: Approach) -> bool:
        start = approach.track[-1]
        return any(self._collider.walkable(start, self._places[cell], self._body) for cell in approach.cells)

    def _way_out(self, foot: FloatArray) -> Approach | None:
        """Return the shortest path to cells in sliding moves; None if the body overlaps a surface or cannot get out."""
        if self._collider.touching(foot, self._body) is not None:
            return None
        waiting: list[tuple[float, int, FloatArray]] = [(0.0, 0, foot[None])]
        number, seen = 0, {self._square(foot)}
        while waiting and number < MOST_PLACES * len(TURNS_DEG):
            length, _, track = heapq.heappop(waiting)
            near = self._around(track[-1])
            if self._is_open(near):
                return Approach(track, near.cells, length + near.gaps)
            for turn in TURNS_DEG:
                number += 1
                motion = self._collider.move(track[-1], turn, STRIDE_M, self._body, slide=True)
                if self._square(motion.foot) not in seen:
                    seen.add(self._square(motion.foot))
                    way = np.concatenate([track, motion.track[1:]])
                    heapq.heappush(waiting, (length + motion.travelled_m, number, way))
        return None

    def _square(self, foot: FloatArray) -> tuple[int, ...]:
        return tuple(math.floor(value / self._cell_m) for value in foot)


CELL_M = 0.1
"""Edge of a cell, metres."""

CACHE_VERSION = 1
"""Version of the cells in the cache. Increase this number when the code finds other cells for the same scene and
settings.
"""


@dataclass(frozen=True, eq=False)
class Field:
    """The shortest path from each cell to the nearest goal.

    Attributes:
        distance: (n,) length of the path from each cell, metres; inf without a path.
        following: (n,) next cell on the path from each cell; negative at a goal or without a path.
    """

    distance: FloatArray
    following: IntArray


class Navigator:
    """Finds places where a body can walk, and the shortest paths between them.

    Lengths are seen from above.

    Args:
        collider: the scene, its bounds and its floor.
        cell_m: edge of a cell, metres.
        cache: folder for the cached cells; None means no cache.
    """

    def __init__(self, collider: Collider, body: Body, *, cell_m: float = CELL_M, cache: Path | None = None) -> None:
        self.collider, self.body, self.cell_m = collider, body, cell_m
        self._walkable = self._load(cache)
        self._graph = self._walkable.graph()
        self._component: IntArray = connected_components(self._graph, directed=False)[1].astype(np.int64)
        self._approaches = Approaches(collider, body, self.places, cell_m)
        self._sight = SightLines(collider.scene, collider.ground.surfaces)

    @property
    def places(self) -> FloatArray:
        """For each walkable cell, the place of a foot at the cell's centre, (n, 3), metres."""
        return self._walkable.places

    def target(self, prims: Iterable[str]) -> TargetSurfaces:
        """Return the surfaces of the prims with these paths, and of the prims below them, as one target."""
        return TargetSurfaces(self.collider.ground.surfaces, prims)

    def line_of_sight(self, eye: FloatArray, target: TargetSurfaces) -> bool:
        """Return whether at least one straight line from `eye` (3,) to a point of the target meets no obstacle."""
        return self._sight.reaches(eye, target)

    def goal_cells(self, target: TargetSurfaces, radius_m: float, eye_height_m: float) -> IntArray:
        """Return the indices of the cells with the target in line of sight, and within a radius seen from above."""
        near = np.flatnonzero(target.is_near(self.places, radius_m))
        eye = np.array([0.0, 0.0, eye_height_m])
        return np.array([i for i in near if self.line_of_sight(self.places[i] + eye, target)], np.int64)

    def distance_field(self, goals: IntArray) -> Field:
        """Return the shortest paths from all cells to the nearest of these goal cells."""
        if not len(goals):
            size = len(self.places)
            return Field(np.full(size, np.inf), np.full(size, -1, np.int64))
        shortest = dijkstra(self._graph, directed=False, indices=goals, min_only=True, return_predecessors=True)
        return Field(shortest[0], shortest[1].astype(np.int64))

    def distance(self, foot: FloatArray, field: Field) -> float:
        """Return the length of the shortest path from `foot` (3,) to the nearest goal, metres; inf without a path."""
        way = self._approaches.find(foot)
        if not way.cells.size:
            return float("inf")
        if field.distance[way.cells[0]] == 0 and len(way.track) == 1:
            return 0.0
        return float((field.distance[way.cells] + way.gaps).min())

    def path(self, foot: FloatArray, field: Field) -> Route | None:
        """Return the shortest path from `foot` (3,) to the nearest goal in straight moves, or None without a path."""
        approach = self._approaches.find(foot)
        cells, track = approach.cells, approach.track
        ways = field.distance[cells] + approach.gaps
        order = [i for i in np.argsort(ways, kind="stable") if np.isfinite(ways[i])]
        if not order:
            return None
        if field.distance[cells[0]] == 0 and len(track) == 1:
            return Route.of(np.array([foot]))
        open_ways = (i for i in order if self.collider.walkable(track[-1], self.places[cells[i]], self.body))
        chain = [int(cells[next(open_ways, order[0])])]
        while (following := int(field.following[chain[-1]])) >= 0:
            chain.append(following)
        return direct(self.collider, np.concatenate([track, self.places[chain]]), self.body, self.cell_m)

    def cell(self, foot: FloatArray) -> int | None:
        """Return the cell at which the path from `foot` (3,) enters the grid of cells; None without such a path."""
        cells = self._approaches.find(foot).cells
        return int(cells[0]) if cells.size else None

    def reachable(self, foot: FloatArray) -> IntArray:
        """Return the ascending indices of the cells that the body can reach from `foot` (3,)."""
        cell = self.cell(foot)
        return np.flatnonzero(self._component == (-1 if cell is None else self._component[cell]))

    def visited(self, track: FloatArray, reach_m: float) -> IntArray:
        """Return the ascending indices of the cells within reach of the straight lines through (k, 3) places.

        The cells that contain the lines are always included.
        """
        parts = [track[:1]]
        for start, end in pairwise(track):
            count = math.ceil(float(np.linalg.norm(end - start)) / self.cell_m)
            parts.append(start + (end - start) * np.linspace(0, 1, count + 1)[1:, None])
        return self._approaches.within(np.concatenate(parts), reach_m)

    def random_foot(
        self, rng: Generator, region: FloatArray, *, clearance_m: float = 0.0, field: Field | None = None
    ) -> FloatArray:
        """Return a random place (3,) where the body can stand.

        Args:
            rng: draws the place.
            region: (2, 2) or (2, 3) lowest and highest corner of the region, metres. Without heights, the place is on
                the lowest floor that covers a good part of the region, not on a roof or a table.
            clearance_m: smallest distance from the body's axis to the nearest obstacle, metres.
            field: if given, only places with a path to one of the goals of this field are drawn.
        """
        axes = region.shape[1]
        inside = ((self.places[:, :axes] >= region[0]) & (self.places[:, :axes] <= region[1])).all(axis=1)
        inside &= self._walkable.clearance >= clearance_m
        if field is not None:
            inside &= np.isfinite(field.distance)
        cells = np.flatnonzero(inside)
        if not cells.size:
            raise InputError(
                f"The region {region.tolist()} has no place to start with {clearance_m} m around the body"
                f"{' and a path to the target' if field is not None else ''}. Set a larger world.start.region, "
                "or a smaller world.body."
            )
        return np.array(self.places[rng.choice(cells if axes == 3 else self._lowest_floor(cells))])

    def _lowest_floor(self, cells: IntArray) -> IntArray:
        """Return the lowest floor's cells; floors with less than a quarter of the largest one's cells do not count."""
        labels, inverse = np.unique(self._component[cells], return_inverse=True)
        counts = np.bincount(inverse)
        heights = np.bincount(inverse, self.places[cells, 2]) / counts
        large = np.flatnonzero(counts >= counts.max() / 4)
        return np.asarray(cells[inverse == large[np.argmin(heights[large])]])

    def _load(self, folder: Path | None) -> Walkable:
        """Return the walkable cells from the cache in a folder; if they are not there, compute and cache them."""
        if folder is None:
            return find_walkable(self.collider.ground, self.collider.bounds, self.body, self.cell_m)
        path = folder / f"walkable-{self._digest()}.npz"
        try:
            with np.load(path, allow_pickle=False) as saved:
                return Walkable(saved["places"], saved["clearance"], saved["edges"])
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
            # The file is absent or damaged.
            walkable = find_walkable(self.collider.ground, self.collider.bounds, self.body, self.cell_m)
        folder.mkdir(parents=True, exist_ok=True)
        with NamedTemporaryFile(dir=folder, suffix=".tmp", delete=False) as file:
            np.savez(file, places=walkable.places, clearance=walkable.clearance, edges=walkable.edges)
        Path(file.name).replace(path)
        return walkable

    def _digest(self) -> str:
        settings = {
            "version": CACHE_VERSION,
            "scene": self.collider.scene.sha256,
            "bounds": self.collider.bounds.tolist(),
            "floor_height": self.collider.ground.floor_height,
            "body": asdict(self.body),
            "cell_m": self.cell_m,
        }
        return hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:24]
