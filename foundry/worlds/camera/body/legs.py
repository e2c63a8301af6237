"""One straight piece of a move: up and down with the floor, as far as there is room."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from foundry.worlds.camera.body.ground import Ground
from foundry.worlds.camera.body.outlines import cut, sweep
from foundry.worlds.camera.body.size import Body
from foundry.worlds.camera.loading.scene import FloatArray, IntArray

BOUNDS, EDGE = "bounds", "edge"
"""What stops a move that no surface stops: the bounds of the scene, or a floor that ends."""

SKIN_M = 1e-6
"""Distance the body keeps from what it touches, beside its radius."""

LEVEL_M = 1e-4
"""Difference in height below which a floor counts as level."""

STATION_M = 0.05
"""Distance between the places on the way at which the floor is looked for."""


@dataclass(frozen=True, eq=False)
class Stop:
    """What ended a leg; `normal` (2,) points away from it, and is None where nothing can be slid along."""

    name: str
    normal: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Way:
    """The places (3,) of the foot after the start, and what ended the way, if anything."""

    track: list[FloatArray]
    stop: Stop | None = None


class Leg:
    """A straight way from `foot` (3,) along `heading` (2,).

    The body moves at the height of the last floor it stood on, and rises or sinks where it finds another:
    nothing is passed unseen, however long the way or thin the wall.
    """

    def __init__(self, ground: Ground, bounds: FloatArray, foot: FloatArray, heading: FloatArray, body: Body) -> None:
        self._ground, self._bounds, self._foot, self._heading, self._body = ground, bounds, foot, heading, body

    def go(self, length: float) -> Way:
        """Return how far the body comes on `length` metres."""
        stations = np.linspace(0.0, length, max(math.ceil(length / STATION_M), 1) + 1)
        self._near = self._ground.near(self._points(stations[[0, -1]]), self._body)
        floor, end = self._floor(stations)
        if not floor.size:
            return Way([], end)
        return self._follow(stations[: len(floor)], floor, end)

    def _points(self, stations: FloatArray) -> FloatArray:
        return np.asarray(self._foot[:2] + stations[:, None] * self._heading)

    def _at(self, station: float, height: float) -> FloatArray:
        return np.append(self._foot[:2] + station * self._heading, height)

    def _floor(self, stations: FloatArray) -> tuple[FloatArray, Stop | None]:
        """Return the height of the floor at the stations that it reaches, and what ends it before the last.

        The station after the last one that is carried is moved to the very edge.
        """
        points, foot_z = self._points(stations), float(self._foot[2])
        floor = self._ground.profile(points, foot_z, self._near, self._body)
        if not floor.size:  # a start over nothing: it may still step onto a floor
            floor = np.append(foot_z, self._ground.profile(points[1:], foot_z, self._near, self._body))
        outside = self._out_of_bounds(floor)
        if outside.size:
            return floor[: outside[0]], Stop(BOUNDS)
        if len(floor) == len(stations):
            return floor, None
        carried, empty = stations[len(floor) - 1], stations[len(floor)]
        for _ in range(8):
            middle = (carried + empty) / 2
            here = self._height(middle, float(floor[-1]))
            carried, empty = (carried, middle) if here is None else (middle, empty)
        last = self._height(carried, float(floor[-1]))
        stations[len(floor)] = carried
        return np.append(floor, floor[-1] if last is None else last), Stop(EDGE)

    def _out_of_bounds(self, floor: FloatArray) -> IntArray:
        if self._ground.floor_height is not None:
            return np.empty(0, np.int64)
        low, high = self._bounds[:, 2]
        return np.flatnonzero((floor < low - LEVEL_M) | (floor > high + LEVEL_M))

    def _height(self, station: float, foot_z: float) -> float | None:
        points = self._points(np.array([station]))
        found = self._ground.profile(points, foot_z, self._near, self._body)
        return float(found[0]) if found.size else None

    def _follow(self, stations: FloatArray, floor: FloatArray, end: Stop | None) -> Way:
        """Move from level stretch to level stretch of the floor until something is in the way."""
        track = [self._at(0.0, floor[0])]
        first = 0
        while first < len(floor) - 1:
            level = np.abs(floor[first + 1 :] - floor[first]) <= LEVEL_M
            last = first + 1 + (len(level) - 1 if level.all() else int(np.argmin(level)))
            touched = self._sweep(stations[first], stations[last], float(floor[first]))
            if touched is not None:
                station, stop = touched
                before = max(int(np.searchsorted(stations, station, side="right")) - 1, first)
                track.append(self._settled(station, float(stations[before]), float(floor[first])))
                return Way(track, stop)
            track.append(self._at(stations[last], floor[first]))
            blocked = self._blocked(track[-1], float(floor[last]))
            if blocked is not None:
                track.append(self._at(stations[last - 1], floor[first]))
                return Way(track, Stop(blocked))
            track.append(self._at(stations[last], floor[last]))
            first = last
        return Way(track, end)

    def _sweep(self, start: float, end: float, foot_z: float) -> tuple[float, Stop] | None:
        """Return the station at which the body is stopped between two others, and by what."""
        points = self._points(np.array([start, end]))
        able = self._ground.obstacles(points, foot_z, self._near, self._body)
        outlines = cut(self._ground.surfaces.corners[able], *self._body.span(foot_z))
        touch = sweep(outlines, points[0], self._heading, end - start, self._body.radius_m + SKIN_M)
        if touch is None:
            return None
        return start + touch.distance, Stop(self._ground.name(int(able[touch.owner])), touch.normal)

    def _settled(self, station: float, before: float, foot_z: float) -> FloatArray:
        """Return where the foot comes to rest on the floor at a station, or at the one before if it can not."""
        floor = self._height(station, foot_z)
        if floor is None or self._blocked(self._at(station, foot_z), floor) is not None:
            return self._at(before, foot_z)
        return self._at(station, floor)

    def _blocked(self, foot: FloatArray, height: float) -> str | None:
        """Return the name of what the body would run into by rising or sinking to a height, or None."""
        if abs(foot[2] - height) <= LEVEL_M:
            return None
        gap, owner = self._ground.clearance(np.append(foot[:2], height), self._near, self._body)
        if gap >= self._body.radius_m or gap >= self._ground.clearance(foot, self._near, self._body)[0] - SKIN_M:
            return None
        return self._ground.name(owner)
