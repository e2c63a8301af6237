"""Moves an upright body through a scene: it stops at or slides along surfaces, climbs steps, and stays on the floor."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from foundry.errors import InputError
from foundry.worlds.camera.body.surfaces import Surfaces, cut, nearest_offsets, sweep
from foundry.worlds.camera.loading.scene import FloatArray, IntArray, Scene

RISE_M = 1e-3
"""Tolerance of the step height, since 3D models are seldom exact."""


@dataclass(frozen=True, slots=True)
class Body:
    """A vertical capsule that stands on its foot and climbs over low obstacles.

    Collisions use the cylinder around the capsule, from the step height up. This cylinder is exact beside walls and
    edges; elsewhere it stops the body no later than the capsule would. The steepest slope that the body climbs rises by
    the step height over the length of its radius.

    Attributes:
        radius_m: metres.
        height_m: from the foot to the top of the head, metres.
        step_m: largest step up or down, and maximum height of obstacles that do not stop the body, metres.
    """

    radius_m: float
    height_m: float
    step_m: float = 0.25

    def __post_init__(self) -> None:
        if not (0 < self.radius_m < math.inf and 0 <= self.step_m < self.height_m < math.inf):
            raise InputError(
                f"A body of radius {self.radius_m}, height {self.height_m} and step height {self.step_m} m "
                "cannot move. Give it a radius above 0 and a height above its step height, in metres."
            )

    def span(self, foot_z: float) -> tuple[float, float]:
        """Return the lowest and highest height at which a surface stops a body whose foot is at `foot_z`."""
        return foot_z + self.step_m + RISE_M, foot_z + self.height_m

    def stride(self, foot_z: float) -> tuple[float, float]:
        """Return the lowest and highest floor that the body can step onto from `foot_z`."""
        return foot_z - self.step_m - RISE_M, foot_z + self.step_m + RISE_M


REACH_M = 1e-3
"""A surface farther from the body's axis than its radius plus this distance, metres, is ignored."""

_RING = np.array([[math.cos(turn), math.sin(turn)] for turn in np.arange(8) * math.tau / 8])


class Ground:
    """Floors and obstacles: which surfaces of a scene carry a body, and which stop it.

    Args:
        floor_height: height of the foot everywhere, metres; None means that the foot is on the surface below it.
    """

    def __init__(self, scene: Scene, floor_height: float | None) -> None:
        self.surfaces = Surfaces(scene)
        self.floor_height = floor_height

    def near(self, points: FloatArray, body: Body) -> IntArray:
        """Return the triangles near the box around (k, 2) points, at any height."""
        return self.surfaces.near(*_box(points, body, (-math.inf, math.inf)))

    def obstacles(self, points: FloatArray, foot_z: float, near: IntArray, body: Body) -> IntArray:
        """Return the triangles near (k, 2) points that can stop a body whose foot is at the height `foot_z`."""
        return self.surfaces.overlapping(near, *_box(points, body, body.span(foot_z)))

    def profile(self, points: FloatArray, foot_z: float, near: IntArray, body: Body) -> FloatArray:
        """Return the heights of the foot at the points (k, 2) of a path, only up to the end of the floor."""
        if self.floor_height is not None:
            return np.full(len(points), self.floor_height)
        flat = self.surfaces.flat(near)
        heights = self.surfaces.heights(points, flat)
        levels: list[float] = []
        for point, column in zip(points, heights, strict=True):
            floor = _highest(column, body.stride(foot_z))
            if floor is None:
                floor = self._bridge(point, foot_z, flat, body)
            if floor is None:
                break
            levels.append(foot_z := floor)
        return np.array(levels)

    def _bridge(self, point: FloatArray, foot_z: float, near: IntArray, body: Body) -> float | None:
        """Return the foot's height over a gap in the floor; None if the gap is wider than the body's radius."""
        ring = self.surfaces.heights(point + body.radius_m * _RING, near)
        floors = [_highest(column, body.stride(foot_z)) for column in ring]
        pairs = zip(floors[:4], floors[4:], strict=True)
        return max((min(a, b) for a, b in pairs if a is not None and b is not None), default=None)

    def below(self, place: FloatArray, body: Body) -> float | None:
        """Return the height of the floor below a foot at `place` (3,), or None if there is no floor."""
        if self.floor_height is not None:
            return self.floor_height
        near = self.near(place[None, :2], body)
        return _highest(self.surfaces.heights(place[None, :2], near)[0], (-math.inf, body.stride(float(place[2]))[1]))

    def clearance(self, foot: FloatArray, near: IntArray, body: Body) -> tuple[float, int]:
        """Return the horizontal distance from the body's axis to the nearest obstacle, metres, and its triangle.

        Only obstacles within reach count. Without such an obstacle, the distance is inf and the triangle -1.
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
        """Return the name of the mesh that a triangle belongs to."""
        return self.surfaces.names[int(self.surfaces.mesh[triangle])]


def _box(points: FloatArray, body: Body, heights: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    reach = body.radius_m + REACH_M
    low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
    return np.append(low, heights[0]), np.append(high, heights[1])


def _highest(heights: FloatArray, window: tuple[float, float]) -> float | None:
    inside = heights[(heights >= window[0]) & (heights <= window[1])]
    return float(inside.max()) if inside.size else None


BOUNDS, EDGE = "bounds", "edge"
"""Names of the obstacles that are no meshes: the bounds of the scene, and the end of the floor."""

SKIN_M = 1e-6
"""Gap that remains between a body and the surface that stops it, metres."""

LEVEL_M = 1e-4
"""Difference in height below which a floor counts as level."""

STATION_M = 0.05
"""Distance between two neighbouring places on a path at which the floor's height is measured, metres."""


@dataclass(frozen=True, eq=False)
class Stop:
    """An obstacle that stopped a body; `normal` (2,) points away from it; None if the body cannot slide."""

    name: str
    normal: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Way:
    """A path: the places (3,) of the foot after the start, and the obstacle that stopped the body, or None."""

    track: list[FloatArray]
    stop: Stop | None = None


class Leg:
    """A straight path from `foot` (3,) along `heading` (2,).

    The body moves at the height of the last floor, and rises or sinks at the next floor. The path stops at every
    obstacle, even at a thin wall on a long path.
    """

    def __init__(self, ground: Ground, bounds: FloatArray, foot: FloatArray, heading: FloatArray, body: Body) -> None:
        self._ground, self._bounds, self._foot, self._heading, self._body = ground, bounds, foot, heading, body

    def go(self, length: float) -> Way:
        """Return the body's path over at most `length` metres."""
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
        """Return the floor's height at each station (a place on the path), and the cause if the path ends early.

        The first station without a floor is moved to the edge of the floor.
        """
        points, foot_z = self._points(stations), float(self._foot[2])
        floor = self._ground.profile(points, foot_z, self._near, self._body)
        if not floor.size:  # a start without a floor: the body may still step onto one
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
        heights = self._ground.profile(points, foot_z, self._near, self._body)
        return float(heights[0]) if heights.size else None

    def _follow(self, stations: FloatArray, floor: FloatArray, end: Stop | None) -> Way:
        """Return the path over the floor, made of level parts, up to the first obstacle."""
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
        """Return the first place of a straight path where an obstacle stops the body, and the obstacle; else None."""
        points = self._points(np.array([start, end]))
        able = self._ground.obstacles(points, foot_z, self._near, self._body)
        outlines = cut(self._ground.surfaces.corners[able], *self._body.span(foot_z))
        touch = sweep(outlines, points[0], self._heading, end - start, self._body.radius_m + SKIN_M)
        if touch is None:
            return None
        return start + touch.distance, Stop(self._ground.name(int(able[touch.owner])), touch.normal)

    def _settled(self, station: float, before: float, foot_z: float) -> FloatArray:
        """Return the foot's place on the floor at `station`; if the body cannot reach the floor there, at `before`."""
        floor = self._height(station, foot_z)
        if floor is None or self._blocked(self._at(station, foot_z), floor) is not None:
            return self._at(before, foot_z)
        return self._at(station, floor)

    def _blocked(self, foot: FloatArray, height: float) -> str | None:
        """Return the name of the obstacle that keeps the foot from rising or sinking to a height, or None."""
        if abs(foot[2] - height) <= LEVEL_M:
            return None
        gap, owner = self._ground.clearance(np.append(foot[:2], height), self._near, self._body)
        if gap >= self._body.radius_m or gap >= self._ground.clearance(foot, self._near, self._body)[0] - SKIN_M:
            return None
        return self._ground.name(owner)


LEG_M = 1.0
"""A long path is checked for obstacles in parts of this length, metres."""

SLIDE_M = 0.2
"""After sliding this far along an obstacle, metres, the body tries the requested direction again."""

MAX_TURNS = 100
"""Maximum number of straight pieces of a move that slides along obstacles."""


@dataclass(frozen=True, eq=False)
class Motion:
    """The result of a move.

    Attributes:
        foot: (3,) foot at the end, metres.
        travelled_m: length of the path seen from above, metres.
        stopped_by: label or path of the first mesh that the body touched, `bounds`, `edge` of the floor, or None.
        track: (k, 3) places of the foot; the path is straight between them.
    """

    foot: FloatArray
    travelled_m: float
    stopped_by: str | None
    track: FloatArray


class Collider:
    """Moves bodies through one scene.

    Args:
        bounds: (2, 3) lowest and highest place of the foot, metres; None means the bounds of the scene.
        floor_height: height of the foot everywhere, for scenes without a floor; None means that the body stands on the
            surface below it.
    """

    def __init__(self, scene: Scene, *, bounds: FloatArray | None = None, floor_height: float | None = None) -> None:
        self.scene = scene
        self.ground = Ground(scene, floor_height)
        self.bounds: FloatArray = np.array(scene.bounds if bounds is None else bounds, np.float64)

    def move(
        self, foot: Sequence[float] | FloatArray, direction_deg: float, distance_m: float, body: Body, *, slide: bool
    ) -> Motion:
        """Return the path and the stop of a body that moves in a horizontal direction.

        Args:
            foot: (3,) foot at the start, metres. If the body overlaps a surface there, it can only move away from it.
            direction_deg: counter-clockwise from +X.
            distance_m: requested length of the path, seen from above.
            body: the body.
            slide: whether the body slides along obstacles, by the component of the motion along them; else it stops.
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
        """Return the path `track` extended by a slide along obstacles, (k, 3); `left` is the length that remains."""
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
        """Return the name of a mesh that a body at `foot` (3,) overlaps, or None."""
        gap, owner = self.ground.clearance(foot, self.ground.near(foot[None, :2], body), body)
        return None if gap >= body.radius_m - SKIN_M else self.ground.name(owner)

    def floor_below(self, place: FloatArray, body: Body) -> float | None:
        """Return the height of the floor below a foot at `place` (3,), or None if there is no floor."""
        return self.ground.below(place, body)

    def _straight(self, foot: FloatArray, heading: FloatArray, length: float, body: Body) -> Way:
        """Return the straight path to the requested end, or to the first obstacle, bound or end of the floor."""
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
    """Return how far a path goes within the bounds, metres, and its stop at a bound; None if it meets no bound."""
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
    """Return the direction closest to the wished one that leads along a touched surface and into no surface.

    Return also the component of this direction along the wished one; None if there is no such direction. `touched` are
    the directions (2,) away from the surfaces.
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
    return float(np.hypot(*np.diff(track[:, :2], axis=0).T).sum())
