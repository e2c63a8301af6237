"""From a shortest way to legs that can be told: straight pieces, and the things that are seen at their ends."""

from __future__ import annotations

import math
from collections.abc import Container
from typing import TypeAlias

import msgspec
import numpy as np

from foundry.records import CameraEpisode, Pose
from foundry.worlds.camera.body.pose import make_pose, turn_between
from foundry.worlds.camera.body.walkable import Free
from foundry.worlds.camera.loading.scene import FloatArray
from foundry.worlds.camera.things import Things


class Leg(msgspec.Struct, frozen=True, kw_only=True):
    """One straight piece of a told way.

    Attributes:
        turn: from the heading before, whole degrees, left positive, -180..180.
        metres: its length, seen from above, in tenths.
        end: foot at its end, metres.
        towards: name of the thing that it leads to as seen from its start, or null.
        near: name of the thing that is near its end, seen from there along the leg, or null.
        side: where that is: `ahead`, `left` or `right`, or null.
    """

    turn: int
    metres: float
    end: tuple[float, float, float]
    towards: str | None
    near: str | None
    side: str | None


class FollowEpisode(CameraEpisode, frozen=True, kw_only=True):
    """What holds for an episode in which a way is told (`episode.jsonl`, one line); the way is `shortest_path`.

    Attributes:
        grain: how much is told: `coarse`, `medium` or `fine`.
        instruction: the way in words, by language: `english`, `japanese`.
        legs: the way as it is told, from the start to the goal.
        facing: where the middle of the goal's thing is from its end: degrees from the heading there, left positive, and
            from the horizon, up positive.
    """

    grain: str
    instruction: dict[str, str]
    legs: list[Leg]
    facing: tuple[float, float]


ASIDE_M, MEASURED_ASIDE_M = 0.6, 0.15
"""How far a leg may pass from a corner of the shortest way: one told by what is seen, and by degrees and metres."""

NEAR_M = 2.5
"""How near a thing is to the end of a leg that names it, seen from above."""

TOWARDS_DEG = 10.0
"""How far a leg may lead past the middle of the thing that it leads to."""

AHEAD_DEG = 15.0
"""How far to the side the middle of a thing may be that is ahead."""

_Named: TypeAlias = tuple[str | None, str | None, str | None]
_NOTHING: _Named = (None, None, None)


def legs_of(things: Things, start: Pose, points: FloatArray, goal: str) -> list[Leg]:
    """Return the legs of a way, in whole degrees and tenths of metres.

    Each begins where the rounded ones before it end, so that their errors do not add up.

    Args:
        things: what can be named.
        start: the first pose.
        points: the way, (k, 3) metres, from the start on.
        goal: name of what it leads to, which only its end names.
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
        told = {goal, *(leg.near for leg in legs)}
        towards, near, side = _named(things, before, after, told) if len(legs) < len(points) - 2 else _NOTHING
        place = (after.x, after.y, after.z)
        legs.append(Leg(turn=turn, metres=metres, end=place, towards=towards, near=near, side=side))
        here = end
    return legs


def straightened(points: FloatArray, aside_m: float, is_free: Free) -> FloatArray:
    """Return those of (k, 3) points of a way that are left when corners are passed by that hardly matter.

    A straight leg stands for the points between its ends where none of them is farther than `aside_m` from it and the
    leg is free; else it is split at the farthest one. Source: Ramer 1972; Douglas and Peucker 1973.
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
    """Return how far points (n, 2) are from the straight line between two, (n,)."""
    way = end - start
    along = np.clip((points - start) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
    return np.asarray(np.hypot(*(points - start - along[:, None] * way).T))


def _named(things: Things, before: Pose, after: Pose, told: Container[str | None]) -> _Named:
    """Return what a leg leads towards, what it ends near, and on which side that is; nothing that is told already."""
    seen_first, seen_last = things.seen(before), things.seen(after)
    closer = [name for name in seen_last if name not in told and _comes_near(things, name, before, after)]
    near = min(closer, key=lambda name: things.gap(name, after), default=None)
    ahead = [
        name
        for name in seen_first
        if name not in told and name != near and abs(things.aside(name, before)) <= TOWARDS_DEG
    ]
    towards = max(ahead, key=lambda name: seen_first[name], default=None)
    return towards, near, None if near is None else side_of(things.aside(near, after))


def _comes_near(things: Things, name: str, before: Pose, after: Pose) -> bool:
    gap = things.gap(name, after)
    return gap <= NEAR_M and gap < things.gap(name, before)


def side_of(aside: float) -> str:
    """Return on which side of the heading something is, by its direction, degrees, left positive."""
    if abs(aside) <= AHEAD_DEG:
        return "ahead"
    return "left" if aside > 0 else "right"
