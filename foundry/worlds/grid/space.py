"""The bounded grid: places, areas of cells, neighbours and fires."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Annotated, Any, TypeAlias

import msgspec
import numpy as np
from numpy.typing import NDArray

from foundry.errors import InputError

Cell: TypeAlias = tuple[int, int]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]
Name: TypeAlias = Annotated[str, msgspec.Meta(min_length=1)]
Count: TypeAlias = Annotated[int, msgspec.Meta(ge=1)]
Size: TypeAlias = Annotated[int, msgspec.Meta(ge=0)]
Share: TypeAlias = Annotated[int, msgspec.Meta(ge=0, le=1)] | Annotated[float, msgspec.Meta(ge=0, le=1)]

OFFSETS: dict[str, Cell] = {"up": (0, 1), "down": (0, -1), "left": (-1, 0), "right": (1, 0)}
"""Change of (x, y) by direction; y grows upwards."""

FEW = 100
"""Up to this number of agents, all pairs are compared; for more, a search tree, whose library takes .3 s to load."""

OUTSIDE = -1
"""Index for the area outside all places, among the indices of the places."""


class Place(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A rectangle of cells. Prompts state the capacity of a place, but more agents can enter.

    Attributes:
        name: unique name.
        type: kind of place.
        center: cell in the middle.
        extent: number of cells from the centre to the edge, in x and y.
        capacity: number of agents for which the place is meant.
    """

    name: Name
    type: Name
    center: Cell
    extent: tuple[Size, Size]
    capacity: Count

    @property
    def x_min(self) -> int:
        """Leftmost column."""
        return self.center[0] - self.extent[0]

    @property
    def x_max(self) -> int:
        """Rightmost column."""
        return self.center[0] + self.extent[0]

    @property
    def y_min(self) -> int:
        """Lowest row."""
        return self.center[1] - self.extent[1]

    @property
    def y_max(self) -> int:
        """Highest row."""
        return self.center[1] + self.extent[1]

    def __contains__(self, cell: Cell) -> bool:
        return self.x_min <= cell[0] <= self.x_max and self.y_min <= cell[1] <= self.y_max

    @property
    def area(self) -> int:
        """Number of cells."""
        return (self.x_max - self.x_min + 1) * (self.y_max - self.y_min + 1)

    def overlaps(self, other: "Place") -> bool:
        """Return whether the two places share a cell."""
        apart_in_x = self.x_max < other.x_min or other.x_max < self.x_min
        apart_in_y = self.y_max < other.y_min or other.y_max < self.y_min
        return not (apart_in_x or apart_in_y)


@dataclass(frozen=True, slots=True)
class Field:
    """The grid from -half_size to +half_size on both axes; no agent starts in a place or in a closed cell."""

    half_size: int
    places: tuple[Place, ...]
    closed: frozenset[Cell] = frozenset()

    def __contains__(self, cell: Cell) -> bool:
        """Return whether the cell is on the grid."""
        return abs(cell[0]) <= self.half_size and abs(cell[1]) <= self.half_size

    def areas(self, cells: IntArray) -> IntArray:
        """Return, for n cells (n, 2), the index of the place that contains the cell, or OUTSIDE, (n,)."""
        numbers = np.full(len(cells), OUTSIDE, dtype=np.int64)
        x, y = cells[:, 0], cells[:, 1]
        for index, place in enumerate(self.places):
            inside = (x >= place.x_min) & (x <= place.x_max) & (y >= place.y_min) & (y <= place.y_max)
            numbers[inside] = index
        return numbers

    def area(self, cell: Cell) -> int:
        """Return the index of the place that contains a cell; OUTSIDE if no place does."""
        return next((index for index, place in enumerate(self.places) if cell in place), OUTSIDE)

    def is_free(self, cells: IntArray) -> BoolArray:
        """Return, for n cells (n, 2), whether the cell is on the grid, outside all places and not closed, (n,)."""
        on_grid = (np.abs(cells) <= self.half_size).all(axis=1)
        free = np.asarray(on_grid & (self.areas(cells) == OUTSIDE))
        if self.closed:
            free &= np.array([(x, y) not in self.closed for x, y in cells.tolist()], dtype=np.bool_)
        return free

    @property
    def room(self) -> int:
        """Number of cells where agents can start."""
        axis = np.arange(-self.half_size, self.half_size + 1)
        return int(self.is_free(np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)).sum())

    def check(self) -> None:
        """Raise InputError unless the places are on the grid, do not overlap, and leave room outside."""
        for place in self.places:
            if (place.x_min, place.y_min) not in self or (place.x_max, place.y_max) not in self:
                raise InputError(
                    f"Place '{place.name}' covers X from {place.x_min} to {place.x_max} and Y from {place.y_min} "
                    f"to {place.y_max}, beyond the grid (world.half_size={self.half_size}). Move it or make it smaller."
                )
        for index, place in enumerate(self.places):
            for other in self.places[:index]:
                if place.overlaps(other):
                    raise InputError(f"Places '{other.name}' and '{place.name}' overlap. Move one of them.")
        if sum(place.area for place in self.places) >= (2 * self.half_size + 1) ** 2:
            raise InputError("The places leave no cell outside, where agents start. Use a larger world.half_size.")
        if self.closed and not self.room:
            raise InputError(
                "No cell is left where agents can start: outside places, walls, exits and zones, with a way to an "
                "exit if there are exits. Remove some of these parts, or make a gap in the walls."
            )


def distances(cells: IntArray, target: IntArray) -> NDArray[np.float64]:
    """Return the Euclidean distances between cells; both arguments are broadcast to shape (..., 2)."""
    offsets = cells - target
    # The root of an exact integer is the same on every machine; hypot is not.
    return np.asarray(np.sqrt((offsets * offsets).sum(axis=-1)), dtype=np.float64)


@lru_cache(maxsize=8)
def _all_pairs(count: int) -> tuple[IntArray, IntArray]:
    """Return the first and the second agent of every pair, two arrays of shape (n (n - 1) / 2,)."""
    left, right = np.triu_indices(count, 1)
    return left.astype(np.int64), right.astype(np.int64)


def _near_pairs(cells: IntArray, reach: float) -> tuple[IntArray, IntArray]:
    """Return the first and the second agents of all pairs within `reach`; a few pairs may be farther apart."""
    from scipy.spatial import cKDTree

    # Slightly more than `reach`, so that the tree's rounding never decides.
    pairs = cKDTree(cells).query_pairs(reach * (1 + 1e-9), output_type="ndarray").astype(np.int64)
    return pairs[:, 0], pairs[:, 1]


def neighbours(cells: IntArray, areas: IntArray, reach: float) -> Sequence[tuple[int, ...]]:
    """Return, for each agent, the ascending ids of its neighbours: the agents within `reach` in the same area.

    Args:
        cells: positions, (n, 2).
        areas: area of each agent, (n,).
        reach: largest Euclidean distance, cells.
    """
    count = len(cells)
    left, right = _all_pairs(count) if count <= FEW else _near_pairs(cells, reach)
    near = (areas[left] == areas[right]) & (distances(cells[left], cells[right]) <= reach)
    left, right = left[near], right[near]
    ordered = np.sort(np.concatenate([left * count + right, right * count + left]))
    bounds = np.searchsorted(ordered, np.arange(count + 1) * count).tolist()
    ids = (ordered % count).tolist()
    return [tuple(ids[start:end]) for start, end in pairwise(bounds)]


class Fire(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A fire that agents perceive. A fire can also spread (`spread` above 0) or kill agents (`risk` above 0).

    Attributes:
        name: unique name.
        start: first step at which agents can perceive the fire.
        position: the fire's cell.
        intensity: 0 to 1.
        radius: agents perceive the fire up to this Euclidean distance from its nearest burning cell, cells.
        spread: probability per step that a burning cell ignites a neighbouring one.
        risk: probability that an agent dies if it ends a step in a burning cell.
    """

    name: Name
    start: Count
    position: Cell
    # int stays int, since prompts show the numbers as configured.
    intensity: Share
    radius: Annotated[int, msgspec.Meta(ge=0)] | Annotated[float, msgspec.Meta(ge=0)]
    spread: Share = 0
    risk: Share = 0


def perceived_fires(
    fires: Sequence[Fire], step: int, cells: IntArray, burning: Mapping[str, IntArray] | None = None
) -> list[list[dict[str, Any]]]:
    """Return, for each agent, the fires that the agent perceives at `step`, in the order of the configuration.

    Args:
        fires: the fires.
        step: 1-based step.
        cells: cell of each agent, (n, 2).
        burning: burning cells of each fire by its name, (k, 2); None if no fire spreads.
    """
    seen: list[list[dict[str, Any]]] = [[] for _ in range(len(cells))]
    for fire in fires:
        spots = np.array([fire.position]) if burning is None else burning[fire.name]
        if fire.start > step or not len(spots):  # no spot: its cell already burns with another fire
            continue
        apart = distances(cells[:, None], spots)
        distance, nearest = apart.min(axis=1), apart.argmin(axis=1)
        for agent in np.flatnonzero(distance <= fire.radius).tolist():
            x, y = spots[nearest[agent]].tolist()
            seen[agent].append(_described(fire, (x, y), float(distance[agent])))
    return seen


def fires_perceived_at(cell: Cell, fires: Sequence[Fire], step: int) -> list[dict[str, Any]]:
    """Return the fires that an agent in a cell perceives; use this function only if no fire of the world spreads.

    For a single agent, plain numbers are much faster than arrays.
    """
    apart = [
        (fire, math.sqrt((cell[0] - fire.position[0]) ** 2 + (cell[1] - fire.position[1]) ** 2))
        for fire in fires
        if fire.start <= step
    ]
    return [_described(fire, fire.position, distance) for fire, distance in apart if distance <= fire.radius]


def _described(fire: Fire, spot: Cell, distance: float) -> dict[str, Any]:
    return {
        "name": fire.name,
        "x": spot[0],
        "y": spot[1],
        "intensity": fire.intensity,
        "radius": fire.radius,
        "distance": distance,
    }
