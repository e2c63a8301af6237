"""Ways over a grid, made as straight as the obstacles allow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from foundry.worlds.camera.body.collision import Collider
from foundry.worlds.camera.body.size import Body
from foundry.worlds.camera.loading.scene import FloatArray

MARGIN_M = 0.02
"""What a shortcut leaves between the body and the obstacles: one who follows it is never quite on it."""

PASSES = 4
"""Rounds of shortcuts, at most."""

WORTHWHILE_M = 0.005
"""What another round of shortcuts must have saved."""

Free = Callable[[FloatArray, FloatArray], bool]


@dataclass(frozen=True, eq=False)
class Route:
    """A way in straight moves.

    Attributes:
        points: (k, 3) the start, the turns and the end, metres.
        length_m: seen from above.
    """

    points: FloatArray
    length_m: float

    @classmethod
    def of(cls, points: FloatArray) -> Route:
        """Return the route through (k, 3) points."""
        return cls(points, float(np.hypot(*np.diff(points[:, :2], axis=0).T).sum()))


def direct(collider: Collider, points: FloatArray, body: Body, spacing_m: float) -> Route:
    """Return the route through (k, 3) points with every detour cut short that the body need not make.

    The corners move along the way from round to round, so that it ends up taut; it never grows longer.

    Args:
        collider: tells where straight moves are free.
        points: places one after the other, with free ways between neighbours.
        body: who walks.
        spacing_m: distance between the places that can become corners.
    """
    wide = replace(body, radius_m=body.radius_m + MARGIN_M)
    route = Route.of(_shortened(points, lambda start, end: collider.walkable(start, end, wide)))
    for number in range(PASSES):
        dense = _dense(collider, route.points, body, spacing_m)
        if number % 2:
            shorter = _shortened(dense, lambda start, end: collider.walkable(start, end, wide))
        else:
            shorter = _shortened(dense[::-1], lambda start, end: collider.walkable(end, start, wide))[::-1]
        saved, route = route.length_m - Route.of(shorter).length_m, Route.of(shorter)
        if saved < WORTHWHILE_M:
            break
    return route


def _shortened(points: FloatArray, free: Free) -> FloatArray:
    """Return the points that are left when each is followed by the farthest one it has a free way to."""
    kept = [0]
    while kept[-1] < len(points) - 1:
        here = kept[-1]
        reached, stride = here + 1, 2
        while here + stride < len(points) and free(points[here], points[here + stride]):
            reached, stride = here + stride, 2 * stride
        beyond = min(here + stride, len(points))
        while beyond - reached > 1:
            middle = (reached + beyond) // 2
            reached, beyond = (middle, beyond) if free(points[here], points[middle]) else (reached, middle)
        kept.append(reached)
    return points[kept]


def _dense(collider: Collider, points: FloatArray, body: Body, spacing_m: float) -> FloatArray:
    """Return the points with others on the floor between them, a spacing apart."""
    parts = [points[:1]]
    for start, end in zip(points[:-1], points[1:], strict=True):
        pieces = max(int(np.hypot(*(end - start)[:2]) / spacing_m), 1)
        between = start + np.arange(1, pieces)[:, None] / pieces * (end - start)
        for place in between:
            floor = collider.floor_below(place, body)
            place[2] = place[2] if floor is None else floor
        parts += [between, end[None]]
    return np.concatenate(parts)
