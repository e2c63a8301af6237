"""Moves of an upright body among the surfaces of a scene: it stops or slides, climbs steps and stays on the floor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from foundry.errors import InputError
from foundry.worlds.usd.outlines import Touch, cut, nearest_offsets, sweep
from foundry.worlds.usd.scene import FloatArray, IntArray, Scene
from foundry.worlds.usd.surfaces import Surfaces

BOUNDS, EDGE = "bounds", "edge"
"""What stops a move that no surface stops: the scene's bounds, or a floor that ends."""

SKIN_M = 1e-6
"""Distance the body keeps from what it touches, beside its radius."""

LEVEL_M = 1e-4
"""Difference in height below which a floor counts as level."""

RISE_M = 1e-3
"""By how much a step may be higher than the step height: models are seldom exact."""

STATION_M = 0.05
"""Distance between the places on the way at which the floor is looked for."""

LEG_M = 1.0
"""Length of way that is looked at together."""

MAX_LEGS = 8
"""Changes of direction of one sliding move, at most."""


@dataclass(frozen=True, slots=True)
class Body:
    """A vertical capsule that stands on its foot and walks over what is not higher than a step.

    It is tested as the cylinder around the capsule, from the step height up: exact beside walls and
    edges, and never closer to anything than the capsule may come. The steepest slope it climbs rises
    by the step height over its radius.

    Attributes:
        radius_m: metres.
        height_m: from the foot to the top of the head, metres.
        step_m: what it climbs up or down at once, and what is too low to stop it, metres.
    """

    radius_m: float
    height_m: float
    step_m: float = 0.25

    def __post_init__(self) -> None:
        if not (self.radius_m > 0 and 0 <= self.step_m < self.height_m < math.inf):
            raise InputError(
                f"A body of radius {self.radius_m}, height {self.height_m} and step height {self.step_m} m "
                "can not move. Give it a radius above 0 and a height above its step height, in metres."
            )

    def span(self, foot_z: float) -> tuple[float, float]:
        """Return the heights between which surfaces stop a body whose foot is at `foot_z`."""
        return foot_z + self.step_m + RISE_M, foot_z + self.height_m


@dataclass(frozen=True, eq=False)
class Motion:
    """What came of a move.

    Attributes:
        foot: (3,) where it ended, metres.
        travelled_m: length of the way seen from above, metres.
        stopped_by: label or path of the mesh it touched first, `bounds`, `edge` of the floor, or None.
        track: (k, 3) the way of the foot; it goes straight from one place to the next.
    """

    foot: FloatArray
    travelled_m: float
    stopped_by: str | None
    track: FloatArray


@dataclass(frozen=True, eq=False)
class _Stop:
    """What ended a straight way; `normal` (2,) is None where nothing can be slid along."""

    name: str
    normal: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class _Way:
    """A straight way as far as it went: (k, 3) places of the foot after the start."""

    track: list[FloatArray]
    stop: _Stop | None


class Collider:
    """Moves bodies through one scene.

    Args:
        scene: where.
        bounds: (2, 3) lowest and highest place of the foot, metres; None: the bounds of the scene.
        floor_height: height of the foot everywhere, for scenes without a floor to stand on; None: the
            body stands on the surface below it.
    """

    def __init__(self, scene: Scene, *, bounds: FloatArray | None = None, floor_height: float | None = None) -> None:
        self.scene = scene
        self.surfaces = Surfaces(scene)
        self.bounds: FloatArray = np.array(scene.bounds if bounds is None else bounds, np.float64)
        self.floor_height = floor_height

    def move(
        self, foot: Sequence[float] | FloatArray, direction_deg: float, distance_m: float, body: Body, *, slide: bool
    ) -> Motion:
        """Move the foot horizontally as far as the body can go.

        Args:
            foot: (3,) where it stands, metres; where it overlaps something, only ways out are open.
            direction_deg: counter-clockwise from +X.
            distance_m: length of the way seen from above.
            body: what moves.
            slide: go on along what it touches, with the part of the motion that leads there; else stop.
        """
        angle = math.radians(direction_deg)
        wish = np.array([math.cos(angle), math.sin(angle)])
        track = [np.array(foot, np.float64)]
        heading, share, left = wish, 1.0, float(distance_m)
        stopped_by: str | None = None
        touched: list[FloatArray] = []
        for _ in range(MAX_LEGS):
            way = self._straight(track[-1], heading, left * share, body)
            gone = _length([track[-1], *way.track])
            track += way.track
            left -= gone / share
            if way.stop is None:
                break
            stopped_by = stopped_by or way.stop.name
            if not slide or way.stop.normal is None:
                break
            touched = [*(touched if gone <= SKIN_M else []), way.stop.normal]
            deflected = _deflected(wish, touched)
            if deflected is None:
                break
            heading, share = deflected
        return Motion(track[-1], _length(track), stopped_by, np.array(track))

    def walkable(self, start: FloatArray, end: FloatArray, body: Body) -> bool:
        """Return whether one straight move brings the foot from `start` (3,) to `end` (3,)."""
        way = end[:2] - start[:2]
        motion = self.move(start, math.degrees(math.atan2(way[1], way[0])), math.hypot(*way), body, slide=False)
        return motion.stopped_by is None and abs(motion.foot[2] - end[2]) <= body.step_m + RISE_M

    def touching(self, foot: FloatArray, body: Body) -> str | None:
        """Return the name of what a body at `foot` (3,) overlaps, or None if it has room there."""
        gap, owner = self._clearance(foot, self._near(foot[None, :2], body), body)
        return None if gap >= body.radius_m - SKIN_M else self._name(owner)

    def floor_below(self, place: FloatArray, body: Body) -> float | None:
        """Return the height on which a foot at or above `place` (3,) comes to stand, or None over nothing."""
        if self.floor_height is not None:
            return self.floor_height
        heights = self.surfaces.heights(place[None, :2], self._near(place[None, :2], body))[0]
        below = heights[heights <= place[2] + body.step_m + RISE_M]
        return float(below.max()) if below.size else None

    def _near(self, points: FloatArray, body: Body) -> IntArray:
        """Return the triangles within reach of a body on the way through (k, 2) points, at any height."""
        reach = body.radius_m + 2 * SKIN_M
        low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
        return self.surfaces.near(np.append(low, -np.inf), np.append(high, np.inf))

    def _name(self, triangle: int) -> str:
        return self.surfaces.names[self.surfaces.mesh[triangle]]

    def _straight(self, foot: FloatArray, heading: FloatArray, length: float, body: Body) -> _Way:
        """Go straight on to the end, the first obstacle, the bounds or the end of the floor."""
        length, limit = _within(self.bounds, foot, heading, length)
        track: list[FloatArray] = []
        for number in range(max(math.ceil(length / LEG_M), 1)):
            part = min(LEG_M, length - number * LEG_M)
            way = _Leg(self, track[-1] if track else foot, heading, body).go(part)
            track += way.track
            if way.stop is not None:
                return _Way(track, way.stop)
        return _Way(track, limit)

    def _clearance(self, foot: FloatArray, near: IntArray, body: Body) -> tuple[float, int]:
        """Return the distance (metres, in the plane) from the body's axis to the nearest surface, and its triangle."""
        low, high = body.span(float(foot[2]))
        able = near[self.surfaces.reach(near, low, high)]
        heights = self.surfaces.heights(foot[None, :2], able)[0]
        if ((heights >= low) & (heights <= high)).any():
            return 0.0, int(self.surfaces.level(able)[np.nanargmax((heights >= low) & (heights <= high))])
        outlines = cut(self.surfaces.corners[able], low, high)
        if not outlines.owner.size:
            return math.inf, -1
        gaps = np.hypot(*nearest_offsets(foot[:2], outlines.ends).T)
        first = int(np.argmin(gaps))
        return float(gaps[first]), int(able[outlines.owner[first]])
