"""Moves of an upright body among the surfaces of a scene: it stops or slides, climbs steps and stays on the floor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from foundry.worlds.camera.body.ground import Ground
from foundry.worlds.camera.body.legs import BOUNDS, EDGE, SKIN_M, Leg, Stop, Way
from foundry.worlds.camera.body.size import RISE_M, Body
from foundry.worlds.camera.loading.scene import FloatArray, Scene

__all__ = ["BOUNDS", "EDGE", "Body", "Collider", "Motion"]

LEG_M = 1.0
"""Length of way that is looked at together."""

SLIDE_M = 0.2
"""Length of way along an obstacle after which the body tries the direction that was asked for again."""

MAX_TURNS = 100
"""Straight parts of one sliding move, at most."""


@dataclass(frozen=True, eq=False)
class Motion:
    """What came of a move.

    Attributes:
        foot: (3,) where it ended, metres.
        travelled_m: length of the way seen from above, metres.
        stopped_by: label or path of the mesh it touched first, `bounds`, `edge` of the floor, or None.
        track: (k, 3) the way of the foot, straight from one place to the next.
    """

    foot: FloatArray
    travelled_m: float
    stopped_by: str | None
    track: FloatArray


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
        self.ground = Ground(scene, floor_height)
        self.bounds: FloatArray = np.array(scene.bounds if bounds is None else bounds, np.float64)

    def move(
        self, foot: Sequence[float] | FloatArray, direction_deg: float, distance_m: float, body: Body, *, slide: bool
    ) -> Motion:
        """Move the foot horizontally as far as the body can go.

        Args:
            foot: (3,) where it stands, metres; if it overlaps something there, only ways out are open.
            direction_deg: counter-clockwise from +X.
            distance_m: length of the way seen from above.
            body: what moves.
            slide: go on along what it touches, with the part of the motion that leads there; else stop.
        """
        angle = math.radians(direction_deg)
        wish = np.array([math.cos(angle), math.sin(angle)])
        way = self._straight(np.array(foot, np.float64), wish, max(float(distance_m), 0.0), body)
        track = np.array([foot, *way.track])
        stopped_by = way.stop.name if way.stop else None
        if slide and way.stop and way.stop.normal is not None:
            track = self._slide(track, wish, distance_m - _length(track), body, way.stop.normal)
        return Motion(track[-1], _length(track), stopped_by, track)

    def _slide(self, track: FloatArray, wish: FloatArray, left: float, body: Body, normal: FloatArray) -> FloatArray:
        """Return the track with what comes of the rest of a wish after something was touched."""
        places, touched = list(track), [normal]
        for _ in range(MAX_TURNS):
            deflected = _deflected(wish, touched)
            if left <= SKIN_M or deflected is None:
                break
            heading, share = deflected
            way = self._straight(places[-1], heading, min(left * share, SLIDE_M if touched else left), body)
            gone = _length(np.array([places[-1], *way.track]))
            places += way.track
            left -= gone / share
            touched = touched if gone <= SKIN_M else []
            if way.stop is not None:
                if way.stop.normal is None:
                    break
                touched = [*touched, way.stop.normal]
        return np.array(places)

    def walkable(self, start: FloatArray, end: FloatArray, body: Body) -> bool:
        """Return whether one straight move brings the foot from `start` (3,) to `end` (3,)."""
        way = end[:2] - start[:2]
        motion = self.move(start, math.degrees(math.atan2(way[1], way[0])), math.hypot(*way), body, slide=False)
        return motion.stopped_by is None and bool(abs(motion.foot[2] - end[2]) <= body.step_m + RISE_M)

    def touching(self, foot: FloatArray, body: Body) -> str | None:
        """Return the name of what a body at `foot` (3,) overlaps, or None if it has room there."""
        gap, owner = self.ground.clearance(foot, self.ground.near(foot[None, :2], body), body)
        return None if gap >= body.radius_m - SKIN_M else self.ground.name(owner)

    def floor_below(self, place: FloatArray, body: Body) -> float | None:
        """Return the height on which a foot at or above `place` (3,) comes to stand, or None over nothing."""
        return self.ground.below(place, body)

    def _straight(self, foot: FloatArray, heading: FloatArray, length: float, body: Body) -> Way:
        """Go straight on to the end, the first obstacle, the bounds or the end of the floor."""
        length, limit = _within(self.bounds, foot, heading, length)
        track: list[FloatArray] = []
        for number in range(max(math.ceil(length / LEG_M), 1)):
            start = track[-1] if track else foot
            way = Leg(self.ground, self.bounds, start, heading, body).go(min(LEG_M, length - number * LEG_M))
            track += way.track
            if way.stop is not None:
                return Way(track, way.stop)
        return Way(track, limit)


def _within(bounds: FloatArray, foot: FloatArray, heading: FloatArray, length: float) -> tuple[float, Stop | None]:
    """Return how much of the length stays within the bounds, and what ends it if that is not all."""
    stop = None
    for axis in (0, 1):
        speed = float(heading[axis])
        room = bounds[1, axis] - foot[axis] if speed > 0 else foot[axis] - bounds[0, axis]
        reach = max(float(room) - SKIN_M, 0.0)
        if abs(speed) * length > reach and abs(speed) > 1e-9:
            length = reach / abs(speed)
            normal = np.zeros(2)
            normal[axis] = -math.copysign(1.0, speed)
            stop = Stop(BOUNDS, normal)
    return length, stop


def _deflected(wish: FloatArray, touched: Sequence[FloatArray]) -> tuple[FloatArray, float] | None:
    """Return the direction along one of the touched surfaces and into none, and its share of the wish.

    None where there is none; the wish itself where nothing is touched.
    """
    if not touched:
        return wish, 1.0
    best = None
    for normal in touched:
        along = wish - (wish @ normal) * normal
        share = float(np.hypot(*along))
        if share > (1e-6 if best is None else best[1]) and all(along @ other >= -1e-9 for other in touched):
            best = along / share, share
    return best


def _length(track: FloatArray) -> float:
    """Return the length of (k, 3) places one after the other, seen from above."""
    return float(np.hypot(*np.diff(track[:, :2], axis=0).T).sum())
