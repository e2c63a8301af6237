"""Draws the positions of places and fires in a 2D world, if each seed has its own positions."""

from dataclasses import dataclass
from itertools import combinations
from typing import Any, TypeVar

import msgspec
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from foundry.errors import InputError

Settings = TypeVar("Settings", bound=msgspec.Struct)
MOST_TRIES = 10_000
"""Maximum number of draws; if places overlap in all of these draws, an error says that the grid is too small."""


@dataclass(frozen=True)
class Positions:
    """Drawn positions, in the order of the world's settings.

    Attributes:
        places: the centres of the places, (P, 2).
        fires: the cells of the fires, (F, 2).
    """

    places: NDArray[np.int64]
    fires: NDArray[np.int64]

    def of(self, world: Settings) -> Settings:
        """Return a world's settings with these positions: as `center` of the places and `position` of the fires."""
        placed: Any = world
        return msgspec.structs.replace(
            world,
            places=tuple(
                msgspec.structs.replace(place, center=(x, y))
                for place, (x, y) in zip(placed.places, self.places.tolist(), strict=True)
            ),
            fires=tuple(
                msgspec.structs.replace(fire, position=(x, y))
                for fire, (x, y) in zip(placed.fires, self.fires.tolist(), strict=True)
            ),
        )


class PositionLaw:
    """The distribution from which positions are drawn: places are in the grid and share no cell; fires are anywhere.

    All arrangements of the places are equally likely. Each fire is in any cell with the same probability. If the
    `starts` of agents are given, no place covers a start. This is the distribution of positions given the starts, if
    each agent starts in any cell outside all places.
    """

    def __init__(
        self,
        half_size: int,
        extents: NDArray[np.int64],
        fires: int,
        starts: NDArray[np.int64] | None = None,
    ) -> None:
        """Find, for each place, all cells at which its centre can lie.

        Args:
            half_size: both axes run from -half_size to +half_size.
            extents: cells from the centre of each place to its edge, (P, 2).
            fires: number of fires.
            starts: cells that no place may cover, (N, 2), or None.

        Raises:
            InputError: a place is larger than the grid.
        """
        self._half_size = half_size
        self._extents = extents
        self._fires = fires
        self._centres = [self._possible(extent, starts) for extent in extents]

    def draw(self, rng: Generator) -> Positions:
        """Return one draw.

        Raises:
            InputError: the places are too large or too many to lie on the grid without overlaps.
        """
        for _ in range(MOST_TRIES):
            places = np.array([centres[rng.integers(len(centres))] for centres in self._centres], dtype=np.int64)
            if self._are_apart(places):
                fires = rng.integers(-self._half_size, self._half_size, size=(self._fires, 2), endpoint=True)
                return Positions(places.reshape(-1, 2), fires)
        raise InputError(
            f"world.draw_positions found no room for {len(self._extents)} places in {MOST_TRIES:,} draws: "
            "shrink them or raise half_size."
        )

    def _possible(self, extent: NDArray[np.int64], starts: NDArray[np.int64] | None) -> NDArray[np.int64]:
        """Return the centres, (C, 2), for which a place is inside the grid and covers no cell of `starts`."""
        across, along = (np.arange(half - self._half_size, self._half_size - half + 1) for half in extent.tolist())
        centres = np.stack(np.meshgrid(across, along), axis=-1).reshape(-1, 2)
        if not len(centres):
            raise InputError(
                f"A place of extent {extent.tolist()} is larger than the grid of half_size {self._half_size}. "
                "Shrink it."
            )
        if starts is None:
            return centres
        return np.asarray(centres[self._starts_within(centres, extent, starts) == 0])

    def _starts_within(
        self, centres: NDArray[np.int64], extent: NDArray[np.int64], starts: NDArray[np.int64]
    ) -> NDArray[np.int64]:
        """Return, for each centre, how many cells of `starts` a place there would cover, (C,). Uses cumulative sums."""
        width = 2 * self._half_size + 1
        sums = np.zeros((width + 1, width + 1), dtype=np.int64)
        np.add.at(sums, tuple((starts + self._half_size + 1).T), 1)
        sums = sums.cumsum(axis=0).cumsum(axis=1)
        (left, low), (right, high) = (centres + self._half_size - extent).T, (centres + self._half_size + extent + 1).T
        return np.asarray(sums[right, high] - sums[left, high] - sums[right, low] + sums[left, low])

    def _are_apart(self, places: NDArray[np.int64]) -> bool:
        return all(
            bool((np.abs(places[first] - places[other]) > self._extents[first] + self._extents[other]).any())
            for first, other in combinations(range(len(places)), 2)
        )
