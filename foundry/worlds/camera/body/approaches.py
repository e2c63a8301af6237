"""From where a body stands to the cells of the grid: straight, or out of a place too narrow for any cell."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from foundry.worlds.camera.body.collision import Collider
from foundry.worlds.camera.body.size import Body
from foundry.worlds.camera.loading.scene import FloatArray, IntArray

STRIDE_M = 0.5
"""Length of the moves by which a body feels its way out of a narrow place."""

TURNS_DEG = tuple(range(0, 360, 45))
"""Directions of these moves; sliding turns them along the walls."""

MOST_PLACES = 100
"""Places that are tried from a narrow place, at most."""


@dataclass(frozen=True, eq=False)
class Approach:
    """How the grid is entered.

    Attributes:
        track: (k, 3) places that lead to the cells, the foot first.
        cells: (n,) the cells around the last of them, the nearest first.
        gaps: (n,) length of the way over the track to each, seen from above, metres.
    """

    track: FloatArray
    cells: IntArray
    gaps: FloatArray


class Approaches:
    """Finds the cells around places.

    Args:
        collider: tells where moves are free.
        body: who walks.
        places: (n, 3) the centres of the cells.
        cell_m: edge of a cell, metres.
    """

    def __init__(self, collider: Collider, body: Body, places: FloatArray, cell_m: float) -> None:
        self._collider, self._body, self._places, self._cell_m = collider, body, places, cell_m
        self._tree: Any = KDTree(places)
        self._latest: tuple[bytes, Approach] | None = None

    def find(self, foot: FloatArray) -> Approach:
        """Return how the grid is entered from `foot` (3,); asked again for the same place, the same."""
        key = np.asarray(foot, np.float64).tobytes()
        if self._latest is None or self._latest[0] != key:
            self._latest = (key, self._find(foot))
        return self._latest[1]

    def within(self, track: FloatArray, reach_m: float) -> IntArray:
        """Return the cells that (k, 3) places lie in or come within a reach of, ascending."""
        nearby = self._tree.query_ball_point(track, max(reach_m, 0.71 * self._cell_m))
        return np.unique(np.array([cell for cells in nearby for cell in cells], np.int64))

    def _find(self, foot: FloatArray) -> Approach:
        near = self._around(foot)
        if self._is_open(near):
            return near
        out = self._way_out(foot)
        # Cells around that no straight move leads to, but the way out does, are just round a corner.
        return near if out is None or np.isin(near.cells, out.cells).any() else out

    def _around(self, foot: FloatArray) -> Approach:
        """Return the cells around a place, as far as they are near."""
        reach = max(2 * self._body.radius_m, 5 * self._cell_m)
        gaps, cells = self._tree.query(foot, k=9, distance_upper_bound=reach)
        # Cells much farther off than the nearest one may be on the other side of a wall.
        found = gaps <= gaps[0] + self._cell_m if np.isfinite(gaps[0]) else np.zeros(len(gaps), np.bool_)
        cells = cells[found].astype(np.int64)
        return Approach(foot[None], cells, np.hypot(*(self._places[cells] - foot)[:, :2].T))

    def _is_open(self, approach: Approach) -> bool:
        """Return whether a straight move leads to one of the cells."""
        start = approach.track[-1]
        return any(self._collider.walkable(start, self._places[cell], self._body) for cell in approach.cells)

    def _way_out(self, foot: FloatArray) -> Approach | None:
        """Return the shortest way found to cells by sliding moves, or None where a body cannot stand or leave."""
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
