"""Shapes as tuples of faces, so that joining is `+`; metres, Z up, corners counter-clockwise seen from outside."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

Vector = tuple[float, float, float]
Point2 = tuple[float, float]


@dataclass(frozen=True)
class Face:
    """A flat polygon; `group` names the part of the shape it belongs to, so that a part can have its own look."""

    corners: tuple[Vector, ...]
    uvs: tuple[Point2, ...]
    group: str


Shape = tuple[Face, ...]
UNIT_SQUARE: tuple[Point2, ...] = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))


def add(a: Vector, b: Vector, scale: float = 1.0) -> Vector:
    """Return a + scale * b."""
    return (a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2])


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a: Vector) -> Vector:
    """Return the vector of length 1 in the same direction."""
    length = math.dist(a, (0.0, 0.0, 0.0))
    return (a[0] / length, a[1] / length, a[2] / length)


def quad(origin: Vector, right: Vector, up: Vector, *, group: str = "front", tile: Point2 | None = None) -> Shape:
    """Return a rectangle seen from the side where `right` points right and `up` points up.

    Args:
        origin: lower left corner.
        right: lower edge.
        up: left edge.
        group: name of the part.
        tile: metres per repetition of the texture along both edges; None fits it once.
    """
    corners = (origin, add(origin, right), add(add(origin, right), up), add(origin, up))
    uvs = UNIT_SQUARE
    if tile is not None:
        width, height = math.hypot(*right) / tile[0], math.hypot(*up) / tile[1]
        uvs = tuple((u * width, v * height) for u, v in UNIT_SQUARE)
    return (Face(corners, uvs, group),)


def box(low: Vector, high: Vector, *, tile: Point2 | None = None) -> Shape:
    """Return a box; its groups are `x-`, `x+`, `y-`, `y+`, `z-`, `z+`, its textures upright on all sides."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    dx, dy, dz = x1 - x0, y1 - y0, z1 - z0
    return (
        quad((x0, y1, z0), (0, -dy, 0), (0, 0, dz), group="x-", tile=tile)
        + quad((x1, y0, z0), (0, dy, 0), (0, 0, dz), group="x+", tile=tile)
        + quad((x0, y0, z0), (dx, 0, 0), (0, 0, dz), group="y-", tile=tile)
        + quad((x1, y1, z0), (-dx, 0, 0), (0, 0, dz), group="y+", tile=tile)
        + quad((x1, y0, z0), (-dx, 0, 0), (0, dy, 0), group="z-", tile=tile)
        + quad((x0, y0, z1), (dx, 0, 0), (0, dy, 0), group="z+", tile=tile)
    )


def block(size: Vector, at: Vector = (0.0, 0.0, 0.0), *, tile: Point2 | None = None) -> Shape:
    """Return a box of this size that stands on the point `at`."""
    half = (size[0] / 2, size[1] / 2)
    return box(
        (at[0] - half[0], at[1] - half[1], at[2]), (at[0] + half[0], at[1] + half[1], at[2] + size[2]), tile=tile
    )


def _frame(start: Vector, end: Vector) -> tuple[Vector, Vector, Vector]:
    """Return the axis of a round shape, the right of its end cap seen from outside, and its up."""
    axis = unit(add(end, start, -1.0))
    reference = (0.0, 0.0, 1.0) if abs(axis[2]) < 0.9 else (0.0, 1.0, 0.0)
    right = unit(cross(reference, axis))
    return axis, right, cross(axis, right)


def _circle(centre: Vector, right: Vector, up: Vector, radius: float, segments: int) -> list[Vector]:
    angles = [2 * math.pi * k / segments for k in range(segments)]
    return [add(add(centre, right, radius * math.cos(a)), up, radius * math.sin(a)) for a in angles]


def _strip(lower: list[Vector], upper: list[Vector], group: str) -> Shape:
    n = len(lower)
    uvs = [((k / n, 0.0), ((k + 1) / n, 0.0), ((k + 1) / n, 1.0), (k / n, 1.0)) for k in range(n)]
    return tuple(Face((lower[k], lower[(k + 1) % n], upper[(k + 1) % n], upper[k]), uvs[k], group) for k in range(n))


def _disc_uvs(segments: int, side: float) -> list[Point2]:
    angles = [2 * math.pi * k / segments for k in range(segments)]
    return [(0.5 + side * 0.5 * math.cos(a), 0.5 + 0.5 * math.sin(a)) for a in angles]


def cylinder(
    start: Vector, end: Vector, radius: float, *, end_radius: float | None = None, segments: int = 16
) -> Shape:
    """Return a cylinder or cone; its groups are `side`, `start` and `end`, its caps hold the texture once."""
    _, right, up = _frame(start, end)
    lower = _circle(start, right, up, radius, segments)
    upper = _circle(end, right, up, radius if end_radius is None else end_radius, segments)
    cap_start = Face(tuple(reversed(lower)), tuple(reversed(_disc_uvs(segments, -1.0))), "start")
    cap_end = Face(tuple(upper), tuple(_disc_uvs(segments, 1.0)), "end")
    return (*_strip(lower, upper, "side"), cap_start, cap_end)


def ring(start: Vector, end: Vector, radius: float, hole: float, *, segments: int = 24) -> Shape:
    """Return a tube with walls; its groups are `side`, `inside`, `start` and `end`."""
    _, right, up = _frame(start, end)
    outer, outer_end = (_circle(c, right, up, radius, segments) for c in (start, end))
    inner, inner_end = (_circle(c, right, up, hole, segments) for c in (start, end))
    return (
        _strip(outer, outer_end, "side")
        + _strip(inner_end, inner, "inside")
        + _strip(inner, outer, "start")
        + _strip(outer_end, inner_end, "end")
    )


def sphere(centre: Vector, radius: float, *, squash: float = 1.0, segments: int = 12) -> Shape:
    """Return a ball, `squash` times as high as wide; its group is `side`."""
    rows = segments // 2
    polar = [math.pi * (row / rows - 0.5) for row in range(rows + 1)]
    x, y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    rings = [
        _circle(add(centre, (0, 0, radius * squash * math.sin(p))), x, y, radius * math.cos(p), segments) for p in polar
    ]
    south, north = add(centre, (0, 0, -radius * squash)), add(centre, (0, 0, radius * squash))
    faces = [face for low, high in zip(rings[1:-2], rings[2:-1], strict=True) for face in _strip(low, high, "side")]
    for k in range(segments):
        after = (k + 1) % segments
        faces.append(Face((rings[1][after], rings[1][k], south), UNIT_SQUARE[:3], "side"))
        faces.append(Face((rings[-2][k], rings[-2][after], north), UNIT_SQUARE[:3], "side"))
    return tuple(faces)


def extrusion(profile: Sequence[Point2], x0: float, x1: float) -> Shape:
    """Return a (y, z) profile, counter-clockwise seen from +x, drawn out from x0 to x1; groups `side` and `cap`."""
    near = [(x1, y, z) for y, z in profile]
    far = [(x0, y, z) for y, z in profile]
    caps = [Face(tuple(near), tuple(profile), "cap"), Face(tuple(reversed(far)), tuple(reversed(profile)), "cap")]
    return (*_strip(near, far, "side"), *caps)


def _mapped(shape: Shape, move: Callable[[Vector], Vector]) -> Shape:
    return tuple(replace(face, corners=tuple(move(corner) for corner in face.corners)) for face in shape)


def moved(shape: Shape, offset: Vector) -> Shape:
    """Return the shape displaced."""
    return _mapped(shape, lambda corner: add(corner, offset))


def turned(shape: Shape, degrees: float) -> Shape:
    """Return the shape turned counter-clockwise about the Z axis."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return _mapped(shape, lambda p: (c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]))


def named(shape: Shape, group: str) -> Shape:
    """Return the shape with all its faces in one group."""
    return tuple(replace(face, group=group) for face in shape)
