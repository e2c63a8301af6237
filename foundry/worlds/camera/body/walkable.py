"""Finds the cells of a scene's floors that have room for a body, and straightens paths over them."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from foundry.errors import InputError
from foundry.worlds.camera.body.collision import LEVEL_M, Body, Collider, Ground
from foundry.worlds.camera.body.surfaces import SPACING_M, cut, dotted
from foundry.worlds.camera.loading.scene import FloatArray, IntArray

OFFSETS = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2))
"""Steps from a cell to 16 others: 8 neighbours and 8 knight's moves of chess. Of two opposite steps, such as (1, 0) and
(-1, 0), only one is listed.
"""

LAYER_M = 0.02
"""Thickness of a horizontal layer of the scene, metres. Places in the same layer are checked for obstacles together."""

FAR_M = 1.0
"""Largest clearance that is computed, metres; a larger clearance counts as this one."""

MOST_CELLS = 4_000_000
"""Maximum number of cells in a scene's bounds."""


@dataclass(frozen=True, eq=False)
class Walkable:
    """The places that have room for a body, and the graph of the free straight paths between them.

    Attributes:
        places: (n, 3) possible places of the foot, metres.
        clearance: (n,) distance from the body's axis to the nearest obstacle, metres, at most `FAR_M`.
        edges: (m, 2) pairs of places with a free path between them, in both directions.
    """

    places: FloatArray
    clearance: FloatArray
    edges: IntArray

    def graph(self) -> csr_array:
        """Return the lengths of the edges seen from above, metres, as a sparse (n, n) matrix."""
        lengths = np.hypot(*(self.places[self.edges[:, 0], :2] - self.places[self.edges[:, 1], :2]).T)
        return graph_of(self.edges, lengths, len(self.places))


def graph_of(edges: IntArray, weights: FloatArray, size: int) -> csr_array:
    """Return a graph with m edges (m, 2) and their weights (m,) as a symmetric sparse matrix (size, size)."""
    rows, columns = np.concatenate([edges, edges[:, ::-1]]).T
    return csr_array(coo_array((np.tile(weights, 2), (rows, columns)), shape=(size, size)))


def find_walkable(ground: Ground, bounds: FloatArray, body: Body, cell_m: float) -> Walkable:
    """Return the cells within the bounds (2, 3) at whose centres the body has room, as a graph."""
    low = np.ceil(bounds[0, :2] / cell_m - 0.5).astype(np.int64)
    high = np.floor(bounds[1, :2] / cell_m - 0.5).astype(np.int64)
    if np.prod(np.maximum(high - low + 1, 0)) > MOST_CELLS:
        width, depth = (bounds[1] - bounds[0])[:2]
        side = MOST_CELLS**0.5 * cell_m
        raise InputError(
            f"The bounds are {width:,.0f} x {depth:,.0f} m, but at most {side:.0f} x {side:.0f} m are supported. Set "
            "world.bounds=[[x,y,z],[x,y,z]] (metres) to a part of the scene, or exclude distant prims with "
            "world.scene.exclude. `foundry scene info` shows the sizes."
        )
    cells, heights = _floors(ground, low, high, body, cell_m)
    carried = (heights >= bounds[0, 2] - LEVEL_M) & (heights <= bounds[1, 2] + LEVEL_M)
    if ground.floor_height is None:
        cells, heights = cells[carried], heights[carried]
    large = _without_islands(cells, heights, body, cell_m)
    cells, places = cells[large], np.column_stack([(cells[large] + 0.5) * cell_m, heights[large]])
    clearance = clearances(ground, places, body)
    wide = clearance >= body.radius_m
    cells, places, clearance = cells[wide], places[wide], clearance[wide]
    if not len(places):
        raise InputError(
            "No floor within the bounds has room for the body. Check world.bounds, world.floor and world.body."
        )
    edges = np.concatenate([_neighbours(cells, places[:, 2], offset, body.step_m) for offset in OFFSETS])
    return Walkable(places, clearance, edges[_free(ground, places, clearance, edges, body)])


def _floors(ground: Ground, low: IntArray, high: IntArray, body: Body, cell_m: float) -> tuple[IntArray, FloatArray]:
    """Return the cells (n, 2) and heights (n,) of the floors that have room for the body above a cell's centre."""
    column, row, height = ground.surfaces.columns(low, high, cell_m)
    if ground.floor_height is not None:
        bottom, top = body.span(ground.floor_height)
        taken = np.zeros(np.maximum(high - low + 1, 0), np.bool_)
        within = (height >= bottom) & (height <= top)
        taken[column[within] - low[0], row[within] - low[1]] = True
        cells = np.argwhere(~taken) + low
        return cells, np.full(len(cells), ground.floor_height)
    order = np.lexsort((height, row, column))
    cells, height = np.column_stack([column, row])[order], height[order]
    above = np.append(height[1:], np.inf) - height
    last = np.append((cells[1:] != cells[:-1]).any(axis=1), True)[: len(height)]
    able = last | (above[: len(height)] > body.height_m)
    return cells[able], height[able]


def _without_islands(cells: IntArray, heights: FloatArray, body: Body, cell_m: float) -> IntArray:
    """Return the ascending indices of the cells whose connected area is at least as large as four bodies."""
    edges = np.concatenate([_neighbours(cells, heights, offset, body.step_m) for offset in OFFSETS[:2]])
    labels = connected_components(graph_of(edges, np.ones(len(edges)), len(cells)), directed=False)[1]
    smallest = 4 * (2 * body.radius_m / cell_m) ** 2
    return np.flatnonzero(np.bincount(labels, minlength=1)[labels] >= smallest)


def _neighbours(cells: IntArray, heights: FloatArray, offset: tuple[int, int], step_m: float) -> IntArray:
    """Return the pairs (m, 2) of cells that are `offset` apart and differ in height by at most `step_m`."""
    if not len(cells):
        return np.empty((0, 2), np.int64)
    low = cells.min(axis=0) - 2
    width = int(cells[:, 1].max()) - low[1] + 3
    keys = (cells[:, 0] - low[0]) * width + cells[:, 1] - low[1]
    order = np.argsort(keys, kind="stable")
    wanted = keys + offset[0] * width + offset[1]
    first, last = (np.searchsorted(keys[order], wanted, side=side) for side in ("left", "right"))
    counts = last - first
    start = np.repeat(np.arange(len(cells)), counts)
    within = np.arange(len(start)) - np.repeat(np.cumsum(counts) - counts, counts)
    end = order[np.repeat(first, counts) + within]
    close = np.abs(heights[start] - heights[end]) <= step_m
    return np.asarray(np.column_stack([start, end])[close])


def clearances(ground: Ground, places: FloatArray, body: Body) -> FloatArray:
    """Return, for each of (n, 3) places of a body, the distance from its axis to the nearest obstacle, metres, (n,).

    Distances above `FAR_M` become `FAR_M`. Only edges of surfaces count, so a large table above a place is ignored.
    """
    result = np.full(len(places), FAR_M)
    layers = np.floor(places[:, 2] / LAYER_M)
    for layer in np.unique(layers):
        chosen = np.flatnonzero(layers == layer)
        here = places[chosen]
        bottom, top = body.span(here[:, 2].min())[0], body.span(here[:, 2].max())[1]
        low, high = here[:, :2].min(axis=0) - FAR_M, here[:, :2].max(axis=0) + FAR_M
        near = ground.surfaces.near(np.append(low, bottom), np.append(high, top))
        points = dotted(cut(ground.surfaces.corners[near], bottom, top))
        if len(points):
            gaps = KDTree(points).query(here[:, :2], distance_upper_bound=FAR_M)[0]
            gaps = np.sqrt(np.maximum(gaps**2 - (SPACING_M / 2) ** 2, 0.0))
            result[chosen] = np.minimum(gaps, FAR_M)
    return result


def _free(ground: Ground, places: FloatArray, clearance: FloatArray, edges: IntArray, body: Body) -> IntArray:
    """Return the ascending indices of the edges (pairs of neighbouring cells) along which the body has room."""
    starts, ends = places[edges[:, 0]], places[edges[:, 1]]
    lengths = np.hypot(*(starts - ends)[:, :2].T)
    room = np.minimum(clearance[edges[:, 0]], clearance[edges[:, 1]])
    unsure = np.flatnonzero(clearance[edges].sum(axis=1) - lengths < 2 * body.radius_m)
    for side in (starts, ends):  # the middle of an edge may be at the height of either end
        middles = np.column_stack([(starts + ends)[unsure, :2] / 2, side[unsure, 2]])
        room[unsure] = np.minimum(room[unsure], clearances(ground, middles, body))
    # An obstacle beside an edge is at most a quarter of its length from the nearest of three tested places.
    needed = np.hypot(body.radius_m, lengths / 4)
    free = np.ones(len(edges), np.bool_)
    free[unsure] = room[unsure] >= needed[unsure]
    return np.flatnonzero(free)


MARGIN_M = 0.02
"""A shortcut keeps this gap between the body and obstacles, metres, since nobody follows a path exactly."""

PASSES = 4
"""Largest number of times that a path is shortened."""

WORTHWHILE_M = 0.005
"""A path is shortened once more only if the last shortening saved at least this length, metres."""

Free = Callable[[FloatArray, FloatArray], bool]
"""Returns whether a straight path between two places (3,) is free."""


@dataclass(frozen=True, eq=False)
class Route:
    """A path in straight moves.

    Attributes:
        points: (k, 3) the start, the turns and the end, metres.
        length_m: length of the route seen from above, metres.
    """

    points: FloatArray
    length_m: float

    @classmethod
    def of(cls, points: FloatArray) -> "Route":
        """Return the route through (k, 3) points."""
        return cls(points, float(np.hypot(*np.diff(points[:, :2], axis=0).T).sum()))


def direct(collider: Collider, points: FloatArray, body: Body, spacing_m: float) -> Route:
    """Return the route through (k, 3) points after cutting its unnecessary detours short.

    In each round, the corners of the route move as if a rope along the route were pulled tight, so the route never
    becomes longer.

    Args:
        collider: checks straight moves.
        points: places in order, with free paths between neighbours.
        body: the body.
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
    """Return a path's points; a point is left out if the straight line past it is free of obstacles."""
    corners = [0]
    while corners[-1] < len(points) - 1:
        here = corners[-1]
        reached, stride = here + 1, 2
        while here + stride < len(points) and free(points[here], points[here + stride]):
            reached, stride = here + stride, 2 * stride
        beyond = min(here + stride, len(points))
        while beyond - reached > 1:
            middle = (reached + beyond) // 2
            reached, beyond = (middle, beyond) if free(points[here], points[middle]) else (reached, middle)
        corners.append(reached)
    return points[corners]


def _dense(collider: Collider, points: FloatArray, body: Body, spacing_m: float) -> FloatArray:
    """Return a path's points and additional points on the floor between them, `spacing_m` apart."""
    parts = [points[:1]]
    for start, end in zip(points[:-1], points[1:], strict=True):
        pieces = max(int(np.hypot(*(end - start)[:2]) / spacing_m), 1)
        between = start + np.arange(1, pieces)[:, None] / pieces * (end - start)
        for place in between:
            floor = collider.floor_below(place, body)
            place[2] = place[2] if floor is None else floor
        parts += [between, end[None]]
    return np.concatenate(parts)
