"""Shortest ways over the floors of a scene, on a grid that is built once and kept on disk."""

from __future__ import annotations

import hashlib
import json
import math
import zipfile
import zlib
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from tempfile import NamedTemporaryFile

import numpy as np
from numpy.random import Generator
from scipy.sparse.csgraph import connected_components, dijkstra

from foundry.errors import InputError
from foundry.worlds.camera.body.approaches import Approaches
from foundry.worlds.camera.body.collision import Collider
from foundry.worlds.camera.body.routes import Route, direct
from foundry.worlds.camera.body.size import Body
from foundry.worlds.camera.body.targets import SightLines, TargetSurfaces
from foundry.worlds.camera.body.walkable import Walkable, find_walkable
from foundry.worlds.camera.loading.scene import FloatArray, IntArray

CELL_M = 0.1
"""Edge of a cell."""

CACHE_VERSION = 1
"""Raised whenever the same scene and settings give other cells."""


@dataclass(frozen=True, eq=False)
class Field:
    """Shortest ways from every cell to the nearest of some goals.

    Attributes:
        distance: (n,) length of the way from each cell, metres; inf where there is none.
        following: (n,) the next cell of the way; negative at the goals and where there is none.
    """

    distance: FloatArray
    following: IntArray


class Navigator:
    """Knows where in a scene a body can walk, and how far it is.

    Lengths are seen from above, like the distance of a move.

    Args:
        collider: the scene, its bounds and its floor.
        body: who walks.
        cell_m: edge of a cell, metres.
        cache: folder in which the cells are kept; None: nowhere.
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
        """(n, 3) where a foot can stand at the centre of each walkable cell, metres."""
        return self._walkable.places

    def target(self, prims: Iterable[str]) -> TargetSurfaces:
        """Return the things at and below these prim paths as one target."""
        return TargetSurfaces(self.collider.ground.surfaces, prims)

    def line_of_sight(self, eye: FloatArray, target: TargetSurfaces) -> bool:
        """Return whether anything of the target can be seen from `eye` (3,), in whatever direction it lies."""
        return self._sight.reaches(eye, target)

    def goal_cells(self, target: TargetSurfaces, radius_m: float, eye_height_m: float) -> IntArray:
        """Return the cells no farther than a radius from the target, seen from above, from which it is in sight."""
        near = np.flatnonzero(target.is_near(self.places, radius_m))
        eye = np.array([0.0, 0.0, eye_height_m])
        return np.array([i for i in near if self.line_of_sight(self.places[i] + eye, target)], np.int64)

    def distance_field(self, goals: IntArray) -> Field:
        """Return the shortest ways from all cells to the nearest of the goal cells."""
        if not len(goals):
            size = len(self.places)
            return Field(np.full(size, np.inf), np.full(size, -1, np.int64))
        found = dijkstra(self._graph, directed=False, indices=goals, min_only=True, return_predecessors=True)
        return Field(found[0], found[1].astype(np.int64))

    def distance(self, foot: FloatArray, field: Field) -> float:
        """Return the length of the shortest way from `foot` (3,) to the nearest goal, metres; inf if there is none."""
        way = self._approaches.find(foot)
        if not way.cells.size:
            return float("inf")
        if field.distance[way.cells[0]] == 0 and len(way.track) == 1:
            return 0.0
        return float((field.distance[way.cells] + way.gaps).min())

    def path(self, foot: FloatArray, field: Field) -> Route | None:
        """Return the shortest way from `foot` (3,) to the nearest goal in straight moves, or None if there is none."""
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
        """Return the cell nearest to `foot` (3,), or on the way out of there; None if the body cannot get to any."""
        cells = self._approaches.find(foot).cells
        return int(cells[0]) if cells.size else None

    def reachable(self, foot: FloatArray) -> IntArray:
        """Return the cells that can be reached from `foot` (3,), ascending."""
        cell = self.cell(foot)
        return np.flatnonzero(self._component == (-1 if cell is None else self._component[cell]))

    def visited(self, track: FloatArray, reach_m: float) -> IntArray:
        """Return the cells that straight ways from one of (k, 3) places to the next come within a reach of, ascending.

        The cells that the places themselves lie in are always among them.
        """
        parts = [track[:1]]
        for start, end in pairwise(track):
            count = math.ceil(float(np.linalg.norm(end - start)) / self.cell_m)
            parts.append(start + (end - start) * np.linspace(0, 1, count + 1)[1:, None])
        return self._approaches.within(np.concatenate(parts), reach_m)

    def random_foot(
        self, rng: Generator, region: FloatArray, *, clearance_m: float = 0.0, field: Field | None = None
    ) -> FloatArray:
        """Return a random place (3,) where a foot can stand.

        Args:
            rng: what decides.
            region: (2, 2) or (2, 3) lowest and highest place, metres. Without heights, the lowest floor that
                makes up a good part of the region is meant, not the roof or the table tops.
            clearance_m: distance from the body's axis to the nearest obstacle, at least.
            field: if given, only places from which a goal can be reached.
        """
        axes = region.shape[1]
        inside = ((self.places[:, :axes] >= region[0]) & (self.places[:, :axes] <= region[1])).all(axis=1)
        inside &= self._walkable.clearance >= clearance_m
        if field is not None:
            inside &= np.isfinite(field.distance)
        cells = np.flatnonzero(inside)
        if not cells.size:
            raise InputError(
                f"No place to start in {region.tolist()} with {clearance_m} m around the body"
                f"{' and a way to the target' if field is not None else ''}. Choose a larger region, "
                "or a smaller body or clearance."
            )
        return np.array(self.places[rng.choice(cells if axes == 3 else self._lowest_floor(cells))])

    def _lowest_floor(self, cells: IntArray) -> IntArray:
        """Return those of the cells that belong to the lowest connected floor of a good size among them."""
        labels, inverse = np.unique(self._component[cells], return_inverse=True)
        counts = np.bincount(inverse)
        heights = np.bincount(inverse, self.places[cells, 2]) / counts
        large = np.flatnonzero(counts >= counts.max() / 4)
        return np.asarray(cells[inverse == large[np.argmin(heights[large])]])

    def _load(self, folder: Path | None) -> Walkable:
        """Return the cells kept in a folder, or find them and keep them there."""
        if folder is None:
            return self._find()
        path = folder / f"walkable-{self._digest()}.npz"
        try:
            with np.load(path, allow_pickle=False) as kept:
                return Walkable(kept["places"], kept["clearance"], kept["edges"])
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
            found = self._find()  # absent or damaged: both are cured by writing it anew
        folder.mkdir(parents=True, exist_ok=True)
        with NamedTemporaryFile(dir=folder, suffix=".tmp", delete=False) as file:
            np.savez(file, places=found.places, clearance=found.clearance, edges=found.edges)
        Path(file.name).replace(path)
        return found

    def _find(self) -> Walkable:
        return find_walkable(self.collider.ground, self.collider.bounds, self.body, self.cell_m)

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
