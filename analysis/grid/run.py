"""One recorded run of a 2D world as arrays; what every signature is computed from.

T steps, N agents, F fires. State 0 is the start, drawn by the world; state t is the one after step t.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import msgspec
import numpy as np

from analysis.arrays import READABLE, BoolArray, Decisions, IntArray, TextArray
from analysis.costs import RunCost

OUTSIDE = -1
"""Index of the cells that belong to no place."""

CHOICES = ("stay", "up", "down", "left", "right")
"""What an agent can ask for; `GridRun.choice` holds indices into it."""

HEADINGS: IntArray = np.array([(0, 0), (0, 1), (0, -1), (-1, 0), (1, 0)], dtype=np.int64)
"""Change of (x, y) by choice, (5, 2)."""


class Place(msgspec.Struct, frozen=True):
    """A rectangle of cells; `extent` is the number of cells from the centre to the edge, in x and y."""

    name: str
    center: tuple[int, int]
    extent: tuple[int, int]
    capacity: int

    @property
    def low(self) -> tuple[int, int]:
        """The cell with the least x and y."""
        return (self.center[0] - self.extent[0], self.center[1] - self.extent[1])

    @property
    def high(self) -> tuple[int, int]:
        """The cell with the greatest x and y."""
        return (self.center[0] + self.extent[0], self.center[1] + self.extent[1])


class Fire(msgspec.Struct, frozen=True):
    """A fire that is perceived from step `start` on, within `radius` cells (Euclidean)."""

    name: str
    start: int
    position: tuple[int, int]
    radius: float


class GridSettings(msgspec.Struct, frozen=True):
    """The settings of a 2D world that signatures depend on, as configured."""

    name: str
    half_size: int
    agents: int
    steps: int
    communication_distance: float
    places: tuple[Place, ...] = ()
    fires: tuple[Fire, ...] = ()

    @property
    def width(self) -> int:
        """Cells along each axis."""
        return 2 * self.half_size + 1

    @property
    def cells(self) -> int:
        """Number of cells, all of them reachable from everywhere: nothing but the edge limits a move."""
        return self.width**2

    def areas(self, x: IntArray, y: IntArray) -> IntArray:
        """Return the index of each cell's place, or OUTSIDE; same shape as x and y."""
        found = np.full(x.shape, OUTSIDE, dtype=np.int64)
        for index, place in enumerate(self.places):
            (left, bottom), (right, top) = place.low, place.high
            found[(x >= left) & (x <= right) & (y >= bottom) & (y <= top)] = index
        return found


@dataclass(frozen=True)
class GridRun(Decisions):
    """One complete run of a 2D world.

    Attributes:
        id: the run's id.
        world: its settings.
        x: columns by state and agent, cells, (T + 1, N).
        y: rows by state and agent, cells, (T + 1, N).
        place: index of the place by state and agent, or OUTSIDE, (T + 1, N).
        choice: what was asked for, by step and agent, index into CHOICES, (T, N); STAY where the reply
            could not be read.
        moved: whether the position changed in the step, (T, N).
        outcome: of the action call, index into OUTCOMES, (T, N).
        message_outcome: of the message call, index into OUTCOMES, (T, N).
        fires: whether the fire was perceived before the move, (T, N, F).
        said: the message, or None, (T, N); it counts as said even when nobody was near enough to hear it.
        contacts: rows (1-based step, agent, neighbour) before the move, in both directions, (K, 3).
        deliveries: rows (1-based step, sender, recipient) of delivered messages, (M, 3).
        cost: what the run took, or None where that is unknown.
        readable_only: whether the decisions that could not be read are left out of all that is counted.
        labels: whether a text is a warning, by a labeller; one that is missing has no label. None for the rule of
            `analysis.labelling.warning_rule`.
    """

    id: str
    world: GridSettings
    x: IntArray
    y: IntArray
    place: IntArray
    choice: IntArray
    moved: BoolArray
    outcome: IntArray
    message_outcome: IntArray
    fires: BoolArray
    said: TextArray
    contacts: IntArray
    deliveries: IntArray
    cost: RunCost | None = None
    readable_only: bool = False
    labels: Mapping[str, bool] | None = None

    @property
    def steps(self) -> int:
        """Number of steps, T."""
        return int(self.choice.shape[0])

    @property
    def agents(self) -> int:
        """Number of agents, N."""
        return int(self.choice.shape[1])

    @property
    def decisions(self) -> int:
        """Number of agent-steps, T * N."""
        return int(self.choice.size)

    @cached_property
    def message_readable(self) -> BoolArray:
        """Whether the message, or the silence, was decided by the model, chosen or repaired, (T, N)."""
        return np.isin(self.message_outcome, READABLE)

    @cached_property
    def message_counted(self) -> BoolArray:
        """Which message decisions count, (T, N)."""
        return self.message_readable if self.readable_only else np.ones(self.choice.shape, dtype=np.bool_)

    @property
    def all_readable(self) -> bool:
        """Whether every decision could be read, so that leaving out the others changes nothing."""
        return super().all_readable and bool(self.message_readable.all())

    @cached_property
    def perceived(self) -> BoolArray:
        """Whether any fire was perceived before the move, (T, N)."""
        return np.asarray(self.fires.any(axis=2))

    @cached_property
    def spoke(self) -> BoolArray:
        """Whether a message was said, (T, N)."""
        flags = [text is not None for text in self.said.ravel().tolist()]
        return np.array(flags, dtype=np.bool_).reshape(self.said.shape)

    @cached_property
    def neighbours(self) -> IntArray:
        """Number of agents that could be talked to before the move, (T, N)."""
        counts = np.zeros(self.choice.shape, dtype=np.int64)
        np.add.at(counts, (self.contacts[:, 0] - 1, self.contacts[:, 1]), 1)
        return counts
