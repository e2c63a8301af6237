"""Divides a route into straight legs, and describes the legs truly in English and Japanese."""

import math
from collections.abc import Container, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

import msgspec
import numpy as np

from foundry.records import CameraEpisode, Pose
from foundry.worlds.camera.body.walkable import Free
from foundry.worlds.camera.loading.scene import FloatArray
from foundry.worlds.camera.surroundings import make_pose, turn_between
from foundry.worlds.camera.things import Things


class Leg(msgspec.Struct, frozen=True, kw_only=True):
    """A straight piece of a described route.

    Attributes:
        turn: turn before the leg, whole degrees, left positive, -180..180.
        metres: length seen from above, metres, rounded to tenths.
        end: place of the foot at the end of the leg, metres.
        towards: name of the thing straight ahead at the leg's start, or null.
        near: name of a thing that is near and in view at the leg's end, or null.
        side: where the near thing is at the leg's end: `ahead`, `left` or `right`, or null.
    """

    turn: int
    metres: float
    end: tuple[float, float, float]
    towards: str | None
    near: str | None
    side: str | None


class FollowEpisode(CameraEpisode, frozen=True, kw_only=True):
    """The facts of an episode with a described route: the one line of `episode.jsonl`; `shortest_path` is the route.

    Attributes:
        grain: level of detail: `coarse`, `medium` or `fine`.
        instruction: the route in words, by language: `english`, `japanese`.
        legs: the described legs, from the start to the goal.
        facing: angles to the middle of the goal at the end of the route: from the heading, left positive, and from the
            horizon, up positive, degrees.
    """

    grain: str
    instruction: dict[str, str]
    legs: list[Leg]
    facing: tuple[float, float]


ASIDE_M, MEASURED_ASIDE_M = 0.6, 0.15
"""Largest distance between a leg and a corner of the shortest path, metres; the second value is for routes with
lengths.
"""

NEAR_M = 2.5
"""Largest distance of a near thing from the end of a leg, seen from above, metres."""

TOWARDS_DEG = 10.0
"""Largest angle between a leg and the middle of the thing that it leads towards."""

AHEAD_DEG = 15.0
"""Largest angle between the heading and the middle of a thing at which the thing is called ahead, degrees."""

_Named: TypeAlias = tuple[str | None, str | None, str | None]
_NOTHING: _Named = (None, None, None)


def legs_of(things: Things, start: Pose, points: FloatArray, goal: str) -> list[Leg]:
    """Return the legs of a path, rounded to whole degrees and tenths of metres.

    Each leg begins where the rounded leg before it ends, so rounding errors do not add up.

    Args:
        things: the things that legs can name.
        start: the first pose.
        points: the path from the start, (k, 3), metres.
        goal: name of the thing at the path's end, which no leg may name.
    """
    legs: list[Leg] = []
    here, heading = points[0], start.yaw
    for there in points[1:]:
        across = there - here
        turn = round(turn_between(heading, math.degrees(math.atan2(across[1], across[0]))))
        metres = round(math.hypot(across[0], across[1]), 1)
        heading = (heading + turn) % 360.0
        way = math.radians(heading)
        end = np.array([here[0] + metres * math.cos(way), here[1] + metres * math.sin(way), there[2]])
        before, after = make_pose(here, heading, 0.0), make_pose(end, heading, 0.0)
        told_names = {goal, *(leg.near for leg in legs)}
        towards, near, side = _named(things, before, after, told_names) if len(legs) < len(points) - 2 else _NOTHING
        place = (after.x, after.y, after.z)
        legs.append(Leg(turn=turn, metres=metres, end=place, towards=towards, near=near, side=side))
        here = end
    return legs


def straightened(points: FloatArray, aside_m: float, is_free: Free) -> FloatArray:
    """Return the points (k, 3) of a path without its small detours.

    A straight leg replaces the points between its ends if they are at most `aside_m` from it and the leg is free.
    Otherwise the path is split at the farthest point. Source: Ramer 1972; Douglas and Peucker 1973.
    """
    if len(points) < 3:
        return points
    gaps = _gaps(points[1:-1, :2], points[0, :2], points[-1, :2])
    if gaps.max() <= aside_m and is_free(points[0], points[-1]):
        return points[[0, -1]]
    middle = int(gaps.argmax()) + 1
    halves = (straightened(half, aside_m, is_free) for half in (points[: middle + 1], points[middle:]))
    first, second = halves
    return np.concatenate([first[:-1], second])


def _gaps(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the distance of each of (n, 2) points from the straight line between two others, (n,)."""
    way = end - start
    along = np.clip((points - start) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
    return np.asarray(np.hypot(*(points - start - along[:, None] * way).T))


def _named(things: Things, before: Pose, after: Pose, told_names: Container[str | None]) -> _Named:
    """Return a thing that a leg leads towards, a thing near the leg's end, and the side on which the near thing is.

    Things in `told_names` were named before, and are not named again. None stands for no such thing.
    """
    seen_first, seen_last = things.seen(before), things.seen(after)
    closer = [name for name in seen_last if name not in told_names and _comes_near(things, name, before, after)]
    near = min(closer, key=lambda name: things.gap(name, after), default=None)
    ahead = [
        name
        for name in seen_first
        if name not in told_names and name != near and abs(things.aside(name, before)) <= TOWARDS_DEG
    ]
    towards = max(ahead, key=lambda name: seen_first[name], default=None)
    return towards, near, None if near is None else side_of(things.aside(near, after))


def _comes_near(things: Things, name: str, before: Pose, after: Pose) -> bool:
    gap = things.gap(name, after)
    return gap <= NEAR_M and gap < things.gap(name, before)


def side_of(aside: float) -> str:
    """Return `ahead`, `left` or `right` for an angle from the heading, degrees, left positive."""
    if abs(aside) <= AHEAD_DEG:
        return "ahead"
    return "left" if aside > 0 else "right"


GRAINS = ("coarse", "medium", "fine")
"""Levels of detail: `coarse` gives the goal alone, `medium` the turns with visible things, `fine` each leg's turn and
length.
"""

STRAIGHT_DEG, SLIGHT_DEG, BACK_DEG = 15.0, 50.0, 150.0
"""Words for turns, degrees: up to the first angle "straight on", up to the second "slight", from the third "around"."""

TILT_DEG = 10
"""Smallest angle between the goal and the horizon that a route mentions, degrees."""

Facing: TypeAlias = tuple[float, float]


def told(grain: str, goal: str, legs: Sequence[Leg], facing: Facing) -> dict[str, str]:
    """Return a description of a route to the thing `goal`, by language; `grain` is one of GRAINS."""
    return {language: teller.tell(grain, goal, legs, facing) for language, teller in _TELLERS.items()}


class _Teller:
    """Describes a route in one language; `tell` returns the whole description, the other methods return parts of it."""

    def __init__(self, texts: Mapping[str, str]) -> None:
        self._texts = texts

    def tell(self, grain: str, goal: str, legs: Sequence[Leg], facing: Facing) -> str:
        return self._texts["joint"].join(self._sentences(grain, self._name(goal), legs, facing))

    def _sentences(self, grain: str, goal: str, legs: Sequence[Leg], facing: Facing) -> Iterator[str]:
        if grain == "fine":
            yield from map(self._measured, legs)
            yield self._faced(goal, facing)
        elif grain == "medium" and legs:
            yield from map(self._marked, legs[:-1])
            yield self._said("last", turn=self._turn(legs[-1].turn), goal=goal)
        else:
            yield self._said("goal", goal=goal)
        yield self._said("end", goal=goal)

    def _said(self, text: str, **values: object) -> str:
        return self._texts[text].format(**values)

    def _name(self, name: str) -> str:
        return self._said("name_with_number" if name[-1:].isdigit() else "name", name=name)

    def _side(self, degrees: float) -> str:
        return self._texts["left" if degrees > 0 else "right"]

    def _measured(self, leg: Leg) -> str:
        text = "turn_and_walk" if leg.turn else "walk"
        return self._said(text, side=self._side(leg.turn), degrees=abs(leg.turn), metres=leg.metres)

    def _faced(self, goal: str, facing: Facing) -> str:
        aside, above = map(round, facing)
        way = self._texts["up" if above > 0 else "down"]
        where = self._said("aside" if aside else "straight_ahead", degrees=abs(aside), side=self._side(aside))
        height = self._said("height", degrees=abs(above), way=way) if abs(above) >= TILT_DEG else ""
        return self._said("faced", goal=goal, where=where, height=height)

    def _marked(self, leg: Leg) -> str:
        turn = self._turn(leg.turn)
        towards = self._said("towards", thing=self._name(leg.towards)) if leg.towards else ""
        if leg.near is None or leg.side is None:
            return self._said("on", turn=turn, towards=towards)
        place = self._texts[f"near_{leg.side}"]
        return self._said("on_until_near", turn=turn, towards=towards, near=self._name(leg.near), place=place)

    def _turn(self, degrees: float) -> str:
        if abs(degrees) <= STRAIGHT_DEG:
            return self._texts["straight"]
        if abs(degrees) >= BACK_DEG:
            return self._texts["back"]
        return self._said("slight" if abs(degrees) <= SLIGHT_DEG else "turn", side=self._side(degrees))


_FILE = Path(__file__).with_suffix(".toml")
_TEXTS = msgspec.toml.decode(_FILE.read_bytes(), type=dict[str, dict[str, str]])
_TELLERS = {language: _Teller(texts) for language, texts in _TEXTS.items()}
