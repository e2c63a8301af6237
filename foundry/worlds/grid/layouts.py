"""Start positions of agents: one class per layout, named by `_target_` in `conf/layout`."""

from abc import ABC, abstractmethod
from typing import Any

import msgspec
import numpy as np
from numpy.random import Generator

from foundry.errors import InputError
from foundry.worlds.grid.space import Cell, Count, Field, IntArray, Size
from foundry.worlds.validation import read_settings


class Layout(ABC):
    """A rule for the first positions of agents; several agents may share a cell."""

    def check(self, field: Field, agents: int) -> None:
        """Raise InputError if this number of agents cannot be placed on the field."""

    @abstractmethod
    def draw(self, rng: Generator, field: Field, agents: int) -> IntArray:
        """Return the first positions, (agents, 2)."""


class UniformSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`Uniform` has no settings."""


class Uniform(Layout):
    """Independent uniform draws over the cells outside all places."""

    def __init__(self, **settings: Any) -> None:
        read_settings(UniformSettings, settings, "world.layout")

    def draw(self, rng: Generator, field: Field, agents: int) -> IntArray:
        """Return the first positions, (agents, 2)."""
        return _draw_free(rng, field, agents)


class ClusteredSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of `Clustered`.

    Attributes:
        clusters: number of clusters.
        radius: largest Euclidean distance from the cluster's centre, cells.
    """

    clusters: Count
    radius: Size


class Clustered(Layout):
    """Clusters around uniformly drawn centres outside all places; agents join the clusters in turn."""

    def __init__(self, **settings: Any) -> None:
        self.settings = read_settings(ClusteredSettings, settings, "world.layout")

    def draw(self, rng: Generator, field: Field, agents: int) -> IntArray:
        """Return the first positions, (agents, 2)."""
        centres = _draw_free(rng, field, self.settings.clusters)
        return np.stack([self._near(rng, field, centres[agent % len(centres)]) for agent in range(agents)])

    def _near(self, rng: Generator, field: Field, centre: IntArray) -> IntArray:
        radius = self.settings.radius
        while True:  # ends, because the centre itself is free
            offset = rng.integers(-radius, radius, size=(1, 2), endpoint=True)
            cell = centre + offset
            if (offset * offset).sum() <= radius * radius and field.is_free(cell)[0]:
                return np.asarray(cell[0])


class ExplicitSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of `Explicit`.

    Attributes:
        positions: one [x, y] per agent, in the order of their ids; cells inside places are allowed.
    """

    positions: tuple[Cell, ...]


class Explicit(Layout):
    """The listed positions, equal for every seed."""

    def __init__(self, **settings: Any) -> None:
        self.settings = read_settings(ExplicitSettings, settings, "world.layout")

    def check(self, field: Field, agents: int) -> None:
        """Raise InputError unless there is one position on the grid per agent."""
        positions = self.settings.positions
        if len(positions) != agents:
            raise InputError(f"world.layout.positions lists {len(positions)} cells for {agents} agents. List one each.")
        for agent, cell in enumerate(positions):
            if cell not in field:
                raise InputError(
                    f"world.layout.positions[{agent}] is {list(cell)}, beyond the grid of half_size {field.half_size}."
                )
            if cell in field.closed:
                raise InputError(
                    f"world.layout.positions[{agent}] is {list(cell)}, where nobody can start: in a wall, an exit "
                    "or a zone, or without a way to an exit."
                )

    def draw(self, rng: Generator, field: Field, agents: int) -> IntArray:
        """Return the first positions, (agents, 2)."""
        return np.array(self.settings.positions, dtype=np.int64)


def _draw_free(rng: Generator, field: Field, count: int) -> IntArray:
    """Return `count` cells outside all places, uniform and independent, (count, 2)."""
    found = np.empty((0, 2), dtype=np.int64)
    while len(found) < count:
        cells = rng.integers(-field.half_size, field.half_size, size=(count, 2), endpoint=True)
        found = np.concatenate([found, cells[field.is_free(cells)]])
    return found[:count]
