"""Layouts: rules for the start positions of agents. Each file in `conf/layout` names the class of its layout."""

from abc import ABC, abstractmethod
from typing import Any

import msgspec
import numpy as np
from numpy.random import Generator

from foundry.errors import InputError
from foundry.worlds.grid.space import Cell, Count, Field, IntArray, Size
from foundry.worlds.validation import read_settings


class Layout(ABC):
    """A rule that places the agents at the start; several agents may share a cell."""

    def check(self, field: Field, agents: int) -> None:
        """Raise InputError if this number of agents cannot be placed on the field."""

    @abstractmethod
    def draw(self, rng: Generator, field: Field, agents: int) -> IntArray:
        """Return the start cell (x, y) of each agent, shape (agents, 2)."""


class UniformSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of the uniform layout: it has none."""


class Uniform(Layout):
    """Each agent starts in a random cell outside all places; all these cells are equally likely."""

    def __init__(self, **settings: Any) -> None:
        read_settings(UniformSettings, settings, "world.layout")

    def draw(self, rng: Generator, field: Field, agents: int) -> IntArray:
        """Return the start cell (x, y) of each agent, shape (agents, 2)."""
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
    """Agents start in clusters around random cells outside all places, and are dealt to the clusters in turn."""

    def __init__(self, **settings: Any) -> None:
        self.settings = read_settings(ClusteredSettings, settings, "world.layout")

    def draw(self, rng: Generator, field: Field, agents: int) -> IntArray:
        """Return the start cell (x, y) of each agent, shape (agents, 2)."""
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
    """Agents start in the listed cells, the same for every seed."""

    def __init__(self, **settings: Any) -> None:
        self.settings = read_settings(ExplicitSettings, settings, "world.layout")

    def check(self, field: Field, agents: int) -> None:
        """Raise InputError unless each agent has one listed cell on the grid, and may start there."""
        positions = self.settings.positions
        if len(positions) != agents:
            raise InputError(f"world.layout.positions lists {len(positions)} cells, but there are {agents} agents.")
        for agent, cell in enumerate(positions):
            if cell not in field:
                raise InputError(
                    f"world.layout.positions[{agent}] is {list(cell)}, beyond the grid "
                    f"(world.half_size={field.half_size})."
                )
            if cell in field.closed:
                raise InputError(
                    f"world.layout.positions[{agent}] is {list(cell)}, where nobody can start: the cell is in a wall, "
                    "an exit or a zone, or has no way to an exit."
                )

    def draw(self, rng: Generator, field: Field, agents: int) -> IntArray:
        """Return the start cell (x, y) of each agent, shape (agents, 2)."""
        return np.array(self.settings.positions, dtype=np.int64)


def _draw_free(rng: Generator, field: Field, count: int) -> IntArray:
    """Return `count` random cells outside all places, shape (count, 2)."""
    drawn = np.empty((0, 2), dtype=np.int64)
    while len(drawn) < count:
        cells = rng.integers(-field.half_size, field.half_size, size=(count, 2), endpoint=True)
        drawn = np.concatenate([drawn, cells[field.is_free(cells)]])
    return drawn[:count]
