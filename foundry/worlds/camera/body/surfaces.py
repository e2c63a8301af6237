"""All triangles of a scene in one array, indexed by their place in the plane, and their outlines seen from above.

The body is upright and has a constant width, so it covers a range of heights. Only the part of a surface between the
body's lowest and highest point can touch the body. The body touches this part exactly if, seen from above, the body's
disc touches the outline of the part.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from foundry.errors import InputError, not_found
from foundry.worlds.camera.loading.scene import FloatArray, IntArray, Scene

BUCKET_M = 0.25
"""Edge of one square in the index of triangles, metres; larger in scenes that would need too many squares."""

MAX_BUCKETS = 400
"""Maximum number of squares along the longer side of the scene, in the index of triangles."""

FLOOR_NORMAL = 0.01
"""Upward component of a unit normal below which a triangle is too steep to have a height."""


class Surfaces:
    """The triangles of a scene, indexed by their place; a triangle stops a body from both sides.

    Attributes:
        corners: (n, 3, 3) metres, [triangle, corner, axis].
        mesh: (n,) index of each triangle's mesh.
        names: name of each mesh: its label, else its path.
    """

    def __init__(self, scene: Scene) -> None:
        if not any(len(mesh.triangles) for mesh in scene.meshes):
            raise InputError(f"Scene '{scene.name}' has no surface to stand on. Check world.scene.exclude.")
        corners = np.concatenate([mesh.points[mesh.triangles] for mesh in scene.meshes]).astype(np.float64)
        owners = np.repeat(np.arange(len(scene.meshes)), [len(mesh.triangles) for mesh in scene.meshes])
        sound = np.isfinite(corners).all(axis=(1, 2))
        self.corners: FloatArray = corners[sound]
        self.mesh: IntArray = owners[sound]
        self.names = tuple(mesh.label or mesh.path for mesh in scene.meshes)
        self._paths = tuple(mesh.path for mesh in scene.meshes)
        self._low, self._high = self.corners.min(axis=1), self.corners.max(axis=1)
        self._ends = np.concatenate([self._low, -self._high], axis=1)
        self._inverse = _barycentric(self.corners)
        self._is_flat = ~np.isnan(self._inverse[:, 0, 0])
        self._build_index()

    def _build_index(self) -> None:
        self._origin = self._low[:, :2].min(axis=0)
        extent = self._high[:, :2].max(axis=0) - self._origin
        self._bucket = max(BUCKET_M, float(extent.max()) / MAX_BUCKETS)
        self._shape = (extent // self._bucket).astype(np.int64) + 1
        triangles, column, row = cells_of(self._square(self._low[:, :2]), self._square(self._high[:, :2]))
        squares = row * self._shape[0] + column
        order = np.argsort(squares, kind="stable")
        self._sorted: IntArray = triangles[order]
        self._starts = np.searchsorted(squares[order], np.arange(self._shape.prod() + 1))

    def _square(self, points: FloatArray) -> IntArray:
        squares = np.floor((points - self._origin) / self._bucket).astype(np.int64)
        return np.asarray(np.clip(squares, 0, self._shape - 1))

    def near(self, low: FloatArray, high: FloatArray) -> IntArray:
        """Return the triangles whose boxes overlap the box from `low` (3,) to `high` (3,), ascending."""
        (x0, y0), (x1, y1) = self._square(low[:2]), self._square(high[:2])
        rows = np.arange(y0, y1 + 1) * self._shape[0]
        spans = zip(self._starts[rows + x0], self._starts[rows + x1 + 1], strict=True)
        triangles = np.concatenate([self._sorted[start:stop] for start, stop in spans])
        return np.unique(self.overlapping(triangles, low, high))

    def overlapping(self, triangles: IntArray, low: FloatArray, high: FloatArray) -> IntArray:
        """Return the triangles whose boxes overlap the box from `low` (3,) to `high` (3,)."""
        overlaps = (self._ends[triangles] <= np.concatenate([high, -low])).all(axis=1)
        return np.asarray(triangles[overlaps])

    def flat(self, triangles: IntArray) -> IntArray:
        """Return the triangles that are flat enough to have one height at each place."""
        return np.asarray(triangles[self._is_flat[triangles]])

    def heights(self, points: FloatArray, triangles: IntArray) -> FloatArray:
        """Return the heights (k, m) at which vertical lines through k points, (k, 2), meet m triangles.

        A height is NaN if the triangle misses the line or is too steep.
        """
        corners = self.corners[triangles]
        return _heights(points[:, None] - corners[:, 0, :2], corners, self._inverse[triangles])

    def columns(self, low: IntArray, high: IntArray, cell_m: float) -> tuple[IntArray, IntArray, FloatArray]:
        """Return column, row and height of each point where a triangle meets the vertical line through a cell's centre.

        Cell (i, j) has its centre at ((i + 0.5) cell_m, (j + 0.5) cell_m). Only cells from `low` (2,) to `high` (2,),
        inclusive, are considered.
        """
        able = np.flatnonzero(self._is_flat)
        first = np.maximum(np.ceil(self._low[able, :2] / cell_m - 0.5 - 1e-9).astype(np.int64), low)
        last = np.minimum(np.floor(self._high[able, :2] / cell_m - 0.5 + 1e-9).astype(np.int64), high)
        owner, column, row = cells_of(first, last)
        triangles = able[owner]
        corners = self.corners[triangles]
        centres = (np.column_stack([column, row]) + 0.5) * cell_m
        heights = _heights(centres - corners[:, 0, :2], corners, self._inverse[triangles])
        inside = ~np.isnan(heights)
        return column[inside], row[inside], heights[inside]

    def meshes_under(self, prims: Iterable[str]) -> IntArray:
        """Return the ascending indices of the meshes whose prim is in the list or below a prim of the list."""
        meshes: set[int] = set()
        for prim in prims:
            below = prim.rstrip("/") + "/"
            matches = {i for i, path in enumerate(self._paths) if path == prim or path.startswith(below)}
            if not matches:
                raise not_found("Prim", prim, self._paths, "Only prims with a surface can be targets.")
            meshes |= matches
        return np.array(sorted(meshes), np.int64)


def cells_of(first: IntArray, last: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return, for each cell in n rectangles of cells, the rectangle's number, and the cell's column and row."""
    width, depth = np.maximum(last - first + 1, 0).T
    counts = width * depth
    owner = np.repeat(np.arange(len(first)), counts)
    within = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owner, first[owner, 0] + within % width[owner], first[owner, 1] + within // width[owner]


def _barycentric(corners: FloatArray) -> FloatArray:
    """Return matrices (n, 2, 2) from offsets in the plane to barycentric coordinates; NaN for steep triangles."""
    sides = corners[:, 1:] - corners[:, :1]
    normals = np.cross(sides[:, 0], sides[:, 1])
    area = np.linalg.norm(normals, axis=1)
    usable = (np.abs(normals[:, 2]) > FLOOR_NORMAL * area) & (area > 0)
    determinant = np.where(usable, normals[:, 2], np.nan)
    (ux, uy), (vx, vy) = sides[:, 0, :2].T, sides[:, 1, :2].T
    inverse = np.array([[vy, -vx], [-uy, ux]]).transpose(2, 0, 1)
    return np.asarray(inverse / determinant[:, None, None])


def _heights(offsets: FloatArray, corners: FloatArray, inverse: FloatArray) -> FloatArray:
    """Return the heights of triangles at offsets (..., 2) from their first corner; NaN outside of a triangle."""
    x, y = offsets[..., 0], offsets[..., 1]
    u = x * inverse[:, 0, 0] + y * inverse[:, 0, 1]
    v = x * inverse[:, 1, 0] + y * inverse[:, 1, 1]
    z = corners[:, :, 2]
    heights = z[:, 0] + u * (z[:, 1] - z[:, 0]) + v * (z[:, 2] - z[:, 0])
    inside = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9)
    return np.where(inside, heights, np.nan)


BoolArray = npt.NDArray[np.bool_]

GRAZE = 1e-9
"""Rounding error that is tolerated in the distance between a moving disc and a surface, metres."""

SPACING_M = 0.05
"""Largest distance between neighbouring points when an outline is replaced by points, metres."""

_NEXT = (1, 2, 0)
"""The number of the next corner, for each of a triangle's corners 0, 1 and 2."""

TOUCHING = 1e-12
"""A disc whose centre is closer than this to a segment, metres, lies on it, and may move in every direction."""


@dataclass(frozen=True, eq=False)
class Outlines:
    """Line segments in the plane.

    Attributes:
        ends: (m, 2, 2) metres, [segment, end, axis].
        owner: (m,) index of each segment's triangle.
    """

    ends: FloatArray
    owner: IntArray


@dataclass(frozen=True, eq=False)
class Touch:
    """The place where a moving disc meets a surface, and stops.

    Attributes:
        distance: distance that the disc moved, metres.
        normal: (2,) unit vector from the touched point to the disc's centre.
        owner: index of the touched triangle.
    """

    distance: float
    normal: FloatArray
    owner: int


def cut(corners: FloatArray, low: float, high: float) -> Outlines:
    """Return the outlines, seen from above, of the parts of (n, 3, 3) triangles between two heights, inclusive."""
    following = corners[:, _NEXT]
    sides, inside = _clipped_sides(corners, following, low, high)
    parts = [(sides[inside], np.nonzero(inside)[0])]
    parts += [_section(corners, following, height) for height in (low, high)]
    return Outlines(np.concatenate([ends for ends, _ in parts]), np.concatenate([owner for _, owner in parts]))


def section(corners: FloatArray, height: float) -> FloatArray:
    """Return the (m, 2, 2) segments where (n, 3, 3) triangles cross a height, seen from above."""
    return _section(corners, corners[:, _NEXT], height)[0]


def _clipped_sides(a: FloatArray, b: FloatArray, low: float, high: float) -> tuple[FloatArray, BoolArray]:
    """Return the parts of triangles' sides between two heights, (n, 3, 2, 2), and whether a side has such a part."""
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
    """Return the segments (m, 2, 2) in which triangles cut the plane at `height`, and the triangle of each segment."""
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
    """Return the offsets, (m, 2), from the closest point of each segment (m, 2, 2) to a point, (2,) or (m, 2)."""
    along = ends[:, 1] - ends[:, 0]
    offset = point - ends[:, 0]
    squared = np.einsum("ij,ij->i", along, along)
    part = np.einsum("ij,ij->i", offset, along) / np.where(squared > 0, squared, 1.0)
    return np.asarray(offset - np.clip(part, 0.0, 1.0)[:, None] * along)


def dotted(outlines: Outlines) -> FloatArray:
    """Return points along the outlines, (k, 2), at most `SPACING_M` apart, with the ends of each segment."""
    ends = outlines.ends
    lengths = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    pieces = np.ceil(lengths / SPACING_M).astype(np.int64)
    owner = np.repeat(np.arange(len(ends)), pieces + 1)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(pieces + 1) - pieces - 1, pieces + 1)
    part = number / np.maximum(pieces, 1)[owner]
    return np.asarray(ends[owner, 0] + part[:, None] * (ends[owner, 1] - ends[owner, 0]))


def sweep(outlines: Outlines, centre: FloatArray, heading: FloatArray, length: float, radius: float) -> Touch | None:
    """Return the place where a disc on a straight path is stopped, or None.

    A disc that overlaps an obstacle at the start is shrunk until it does not, so it can move, but not closer. A segment
    through the centre of the disc does not stop the disc.

    Args:
        outlines: the obstacles.
        centre: (2,) centre of the disc at the start, metres.
        heading: (2,) unit vector.
        length: length of the path, metres.
        radius: radius of the disc, metres.
    """
    offsets = nearest_offsets(centre, outlines.ends)
    gaps = np.hypot(offsets[:, 0], offsets[:, 1])
    apart = gaps > TOUCHING
    radius = min(radius, float(gaps[apart].min(initial=math.inf)))
    # The distance to a segment is a convex function of the path: once it stops shrinking, it never shrinks again.
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
    """Return, for each of (m, 2) points, how far a disc moves until it touches the point, (m,); inf if never."""
    x, y = (centre - corners).T
    ahead = x * heading[0] + y * heading[1]
    beside = np.abs(x * heading[1] - y * heading[0])
    hits = (ahead < 0) & (beside < radius - GRAZE)
    reach = np.sqrt(np.where(hits, radius**2 - beside**2, 0.0))
    return np.where(hits, np.maximum(-ahead - reach, 0.0), np.inf)


def _time_to_side(ends: FloatArray, centre: FloatArray, heading: FloatArray, radius: float) -> FloatArray:
    """Return, for each (m, 2, 2) segment, how far a disc moves until it touches the segment, (m,); inf if never."""
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
