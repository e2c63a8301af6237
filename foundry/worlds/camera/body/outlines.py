"""Triangles cut to a range of heights and seen from above, and a disc that moves among them.

An upright body of constant width touches a surface exactly where its disc touches the outline of the part
of the surface that lies between its lower and its upper end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from foundry.worlds.camera.loading.scene import FloatArray, IntArray

BoolArray = npt.NDArray[np.bool_]

GRAZE = 1e-9
"""How much closer than its radius, metres, a disc may pass what it moves along; hides rounding."""


SPACING_M = 0.05
"""Distance between the points that stand for outlines where that is exact enough, metres."""

_NEXT = (1, 2, 0)
"""Which corner of a triangle follows each of its corners."""

TOUCHING = 1e-12
"""Distance, metres, at which a centre lies on a segment: no direction leads away from there."""


@dataclass(frozen=True, eq=False)
class Outlines:
    """Line segments in the plane.

    Attributes:
        ends: (m, 2, 2) metres, [segment, end, axis].
        owner: (m,) index of the triangle each belongs to.
    """

    ends: FloatArray
    owner: IntArray


@dataclass(frozen=True, eq=False)
class Touch:
    """Where a disc is stopped.

    Attributes:
        distance: how far it came, metres.
        normal: (2,) unit vector from what it touches to its centre.
        owner: index of the triangle it touches.
    """

    distance: float
    normal: FloatArray
    owner: int


def cut(corners: FloatArray, low: float, high: float) -> Outlines:
    """Return the outlines of the parts of (n, 3, 3) triangles between two heights, both included."""
    following = corners[:, _NEXT]
    sides, inside = _clipped_sides(corners, following, low, high)
    parts = [(sides[inside], np.nonzero(inside)[0])]
    parts += [_section(corners, following, height) for height in (low, high)]
    return Outlines(np.concatenate([ends for ends, _ in parts]), np.concatenate([owner for _, owner in parts]))


def section(corners: FloatArray, height: float) -> FloatArray:
    """Return the (m, 2, 2) segments in which (n, 3, 3) triangles cross a height, as seen from above."""
    return _section(corners, corners[:, _NEXT], height)[0]


def _clipped_sides(a: FloatArray, b: FloatArray, low: float, high: float) -> tuple[FloatArray, BoolArray]:
    """Return the (n, 3, 2, 2) sides cut to the two heights, and where something is left of them."""
    rise = b[..., 2] - a[..., 2]
    level = rise == 0
    safe = np.where(level, 1.0, rise)
    at_low, at_high = (low - a[..., 2]) / safe, (high - a[..., 2]) / safe
    enter = np.where(level, 0.0, np.maximum(np.minimum(at_low, at_high), 0.0))
    within = np.where((a[..., 2] >= low) & (a[..., 2] <= high), 1.0, -1.0)
    leave = np.where(level, within, np.minimum(np.maximum(at_low, at_high), 1.0))
    flat = (b - a)[..., :2]
    ends = np.stack([a[..., :2] + enter[..., None] * flat, a[..., :2] + leave[..., None] * flat], axis=2)
    return ends, enter <= leave


def _section(a: FloatArray, b: FloatArray, height: float) -> tuple[FloatArray, IntArray]:
    """Return the (m, 2, 2) segments in which the triangles cross a height, and their owners."""
    below = a[..., 2] < height
    crosses = below != below[:, _NEXT]
    owner = np.flatnonzero(crosses.any(axis=1))
    first = np.argmax(crosses[owner], axis=1)
    last = 2 - np.argmax(crosses[owner, ::-1], axis=1)
    side = np.column_stack([first, last])
    start, end = a[owner[:, None], side], b[owner[:, None], side]
    part = (height - start[..., 2]) / (end[..., 2] - start[..., 2])
    return start[..., :2] + part[..., None] * (end - start)[..., :2], owner


def nearest_offsets(point: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the (m, 2) offsets to the point(s), (2,) or (m, 2), from the closest point of each segment."""
    along = ends[:, 1] - ends[:, 0]
    offset = point - ends[:, 0]
    squared = np.einsum("ij,ij->i", along, along)
    part = np.einsum("ij,ij->i", offset, along) / np.where(squared > 0, squared, 1.0)
    return np.asarray(offset - np.clip(part, 0.0, 1.0)[:, None] * along)


def dotted(outlines: Outlines) -> FloatArray:
    """Return (k, 2) points all along the outlines, at most `SPACING_M` apart, their ends among them."""
    ends = outlines.ends
    lengths = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    pieces = np.ceil(lengths / SPACING_M).astype(np.int64)
    owner = np.repeat(np.arange(len(ends)), pieces + 1)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(pieces + 1) - pieces - 1, pieces + 1)
    part = number / np.maximum(pieces, 1)[owner]
    return np.asarray(ends[owner, 0] + part[:, None] * (ends[owner, 1] - ends[owner, 0]))


def sweep(outlines: Outlines, centre: FloatArray, heading: FloatArray, length: float, radius: float) -> Touch | None:
    """Return what stops a disc on a straight way, or None.

    A disc that overlaps something at the start is shrunk to the room it has there: it may go anywhere but
    closer. What its very centre lies on does not stop it.

    Args:
        outlines: what is in the way.
        centre: (2,) where the disc starts, metres.
        heading: (2,) unit vector.
        length: of the way, metres.
        radius: of the disc, metres.
    """
    offsets = nearest_offsets(centre, outlines.ends)
    gaps = np.hypot(offsets[:, 0], offsets[:, 1])
    apart = gaps > TOUCHING
    radius = min(radius, float(gaps[apart].min(initial=math.inf)))
    # The distance to a segment is a convex function of the way: once it does not shrink, it never does.
    nearing = (offsets @ heading < -GRAZE * gaps) & apart & (gaps < radius + length)
    chosen = np.flatnonzero(nearing)
    if not chosen.size:
        return None
    ends = outlines.ends[chosen]
    times = np.minimum(
        _time_to_side(ends, centre, heading, radius),
        np.minimum(*(_time_to_corner(ends[:, i], centre, heading, radius) for i in (0, 1))),
    )
    first = int(np.argmin(times))
    distance = float(times[first])
    if distance > length:
        return None
    away = nearest_offsets(centre + distance * heading, ends[first : first + 1])[0]
    return Touch(distance, away / np.hypot(*away), int(outlines.owner[chosen[first]]))


def _time_to_corner(corners: FloatArray, centre: FloatArray, heading: FloatArray, radius: float) -> FloatArray:
    """Return how far the disc moves until it touches each of (m, 2) points; inf if never."""
    x, y = (centre - corners).T
    ahead = x * heading[0] + y * heading[1]
    beside = np.abs(x * heading[1] - y * heading[0])
    hits = (ahead < 0) & (beside < radius - GRAZE)
    reach = np.sqrt(np.where(hits, radius**2 - beside**2, 0.0))
    return np.where(hits, np.maximum(-ahead - reach, 0.0), np.inf)


def _time_to_side(ends: FloatArray, centre: FloatArray, heading: FloatArray, radius: float) -> FloatArray:
    """Return how far the disc moves until it touches each of (m, 2, 2) segments between its ends; inf if never."""
    along = ends[:, 1] - ends[:, 0]
    length = np.hypot(along[:, 0], along[:, 1])
    unit = along / np.where(length > 0, length, 1.0)[:, None]
    x, y = (centre - ends[:, 0]).T
    gap = y * unit[:, 0] - x * unit[:, 1]
    speed = np.where(gap < 0, -1.0, 1.0) * (heading[1] * unit[:, 0] - heading[0] * unit[:, 1])
    closing = speed < -GRAZE
    time = np.maximum((np.abs(gap) - radius) / np.where(closing, -speed, 1.0), 0.0)
    place = x * unit[:, 0] + y * unit[:, 1] + time * (unit @ heading)
    return np.where(closing & (place >= 0) & (place <= length), time, np.inf)
