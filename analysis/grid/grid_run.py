"""One recorded run of a 2D world as arrays, from which all signatures are computed.

Shapes: T steps, N agents, F fires. State 0 is the start, which the seed draws; state t is the state after step t.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import msgspec
import numpy as np

from analysis.arrays import READABLE, BoolArray, Decisions, IntArray, TextArray

OUTSIDE = -1
"""Index of the place of a cell that is in no place."""

CHOICES = ("stay", "up", "down", "left", "right")
"""Staying and the directions of a move. `GridRun.choice` holds indices into CHOICES + FURTHER_ACTIONS."""

FURTHER_ACTIONS = ("gather", "share", "attack", "reproduce")
"""The further actions of an agent in a world with energy."""

NO_EXIT = -1
"""Index of the exit of an agent that does not leave the world."""

HEADINGS: IntArray = np.array([(0, 0), (0, 1), (0, -1), (-1, 0), (1, 0)], dtype=np.int64)
"""Change of (x, y) by each action in CHOICES, (5, 2)."""


class Place(msgspec.Struct, frozen=True):
    """A rectangle of cells; `extent` is the number of cells from the rectangle's centre to its edges, in x and y."""

    name: str
    center: tuple[int, int]
    extent: tuple[int, int]
    capacity: int

    @property
    def low(self) -> tuple[int, int]:
        """The cell in the lower left corner."""
        return (self.center[0] - self.extent[0], self.center[1] - self.extent[1])

    @property
    def high(self) -> tuple[int, int]:
        """The cell in the upper right corner."""
        return (self.center[0] + self.extent[0], self.center[1] + self.extent[1])


class Fire(msgspec.Struct, frozen=True):
    """A fire that agents within `radius` cells (Euclidean) perceive from step `start` on; it may spread."""

    name: str
    start: int
    position: tuple[int, int]
    radius: float
    spread: float = 0.0


class Exit(msgspec.Struct, frozen=True):
    """Cells by which agents leave the world: at most `capacity` agents in a step, or any number if it is None."""

    name: str
    cells: tuple[tuple[int, int], ...]
    capacity: int | None = None


class Leaders(msgspec.Struct, frozen=True):
    """The agents that know all exits: the first `number` ids."""

    number: int


class Energy(msgspec.Struct, frozen=True):
    """The energy of each agent at the start, and its loss per step."""

    start: int
    loss: int = 1


class Order(msgspec.Struct, frozen=True):
    """From step `start`, all agents are ordered to enter a rectangle, given by two opposite corners."""

    target: tuple[tuple[int, int], tuple[int, int]]
    start: int = 1


class GridSettings(msgspec.Struct, frozen=True):
    """The settings of a 2D world on which signatures depend."""

    name: str
    half_size: int
    agents: int
    steps: int
    communication_distance: float
    places: tuple[Place, ...] = ()
    fires: tuple[Fire, ...] = ()
    walls: tuple[tuple[tuple[int, int], tuple[int, int]], ...] = ()
    exits: tuple[Exit, ...] = ()
    leaders: Leaders | None = None
    energy: Energy | None = None
    order: Order | None = None
    draw_positions: bool = False
    tell_fires: bool = True

    @property
    def width(self) -> int:
        """Number of cells along each axis, W."""
        return 2 * self.half_size + 1

    @property
    def cells(self) -> int:
        """Number of cells without a wall."""
        return int(self.free().sum()) if self.walls else self.width**2

    @property
    def spreads(self) -> bool:
        """True if a fire spreads, so that its cells depend on the step."""
        return any(fire.spread for fire in self.fires)

    def free(self) -> BoolArray:
        """Return which cells have no wall, (W, W); index (0, 0) is the cell with the lowest x and the lowest y."""
        is_free = np.ones((self.width, self.width), dtype=np.bool_)
        half = self.half_size
        for (x, y), (other_x, other_y) in self.walls:
            columns, rows = sorted((x + half, other_x + half)), sorted((y + half, other_y + half))
            is_free[columns[0] : columns[1] + 1, rows[0] : rows[1] + 1] = False
        return is_free

    def areas(self, x: IntArray, y: IntArray) -> IntArray:
        """Return the index of the place of each cell, or OUTSIDE; the result has the shape of x and y."""
        zones = np.full(x.shape, OUTSIDE, dtype=np.int64)
        for index, place in enumerate(self.places):
            (left, bottom), (right, top) = place.low, place.high
            zones[(x >= left) & (x <= right) & (y >= bottom) & (y <= top)] = index
        return zones


@dataclass(frozen=True)
class GridRun(Decisions):
    """One complete run of a 2D world.

    Attributes:
        x: columns by state and agent, cells, (T + 1, N).
        y: rows by state and agent, cells, (T + 1, N).
        place: index of the place by state and agent, or OUTSIDE, (T + 1, N).
        choice: requested action by step and agent, index into CHOICES followed by FURTHER_ACTIONS, (T, N); STAY for an
            unreadable reply.
        moved: whether the agent's cell changed in the step, (T, N).
        outcome: outcome of the action call, index into OUTCOMES, (T, N).
        message_outcome: outcome of the message call, index into OUTCOMES, (T, N).
        fires: whether the agent perceived the fire before the move, (T, N, F); all False if the world does not mention
            fires in observations.
        said: the agent's message, even if nobody hears it, or None, (T, N).
        contacts: rows (1-based step, agent, neighbour) for all pairs that can talk before the move, both ways, (K, 3).
        deliveries: rows (1-based step, sender, recipient) of delivered messages, (M, 3).
        readable_only: whether measures leave out unreadable decisions.
        labels: whether each text is a warning; a text that is missing here has no label. If it is None, the rule of
            `analysis.labelling.warning_rule` labels the texts.
        present: whether the agent was present and asked, (T, N); None if all agents always were. For an absent agent, x
            and y are its first or last cell, the place is OUTSIDE and the outcome is none. Such an agent requests
            nothing and says nothing.
        left: index of the exit by which an agent left in the step, or NO_EXIT, (T, N); None in a world without exits.
        lost: whether the agent died at the end of the step, (T, N); None in a world without deaths.
        living: further numbers in a world with energy, each (T, N), 0 for absent agents. `energy` is the energy before
            the step, `energy_next` the energy after it. `amount` is the energy gathered, shared or taken. `target` is
            the id of the target, -1 for none. `born` says whether the action made a newborn. `food` is the food in the
            cell before the step.
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
    readable_only: bool = False
    labels: Mapping[str, bool] | None = None
    present: BoolArray | None = None
    left: IntArray | None = None
    lost: BoolArray | None = None
    living: Mapping[str, IntArray] | None = None

    @cached_property
    def there(self) -> BoolArray:
        """True for each agent that was present and asked, (T, N)."""
        return np.ones(self.choice.shape, dtype=np.bool_) if self.present is None else self.present

    @property
    def first(self) -> IntArray:
        """Index of the first state of each agent, (N,): 0 for agents that are there from the start."""
        return np.asarray(self.there.argmax(axis=0))

    @property
    def last(self) -> IntArray:
        """Last step of each agent, (N,): T for agents that stay to the end."""
        return np.asarray(self.steps - self.there[::-1].argmax(axis=0))

    @property
    def acted(self) -> BoolArray:
        """True for actions other than staying and moving, (T, N)."""
        return np.asarray(self.choice >= len(CHOICES))

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
        """Number of decisions that choose an action; T * N if all agents are always present."""
        return int(self.there.sum())

    @cached_property
    def message_readable(self) -> BoolArray:
        """True if the reply to the question for a message was readable, (T, N); a reply to stay silent is readable."""
        return np.isin(self.message_outcome, READABLE)

    @cached_property
    def counted(self) -> BoolArray:
        """True for decisions on an action that count in measures, (T, N): all decisions, or only readable ones."""
        return self.readable if self.readable_only else self.there

    @cached_property
    def message_counted(self) -> BoolArray:
        """True for decisions on a message that count in measures, (T, N): all decisions, or only readable ones."""
        return self.message_readable if self.readable_only else self.there

    @property
    def all_readable(self) -> bool:
        """True if all decisions are readable."""
        return bool((self.readable & self.message_readable)[self.there].all())

    @cached_property
    def perceived(self) -> BoolArray:
        """True if the agent perceived a fire before the move, (T, N)."""
        return np.asarray(self.fires.any(axis=2))

    @cached_property
    def spoke(self) -> BoolArray:
        """True if the agent sent a message, even if nobody heard it, (T, N)."""
        flags = [text is not None for text in self.said.ravel().tolist()]
        return np.array(flags, dtype=np.bool_).reshape(self.said.shape)

    @cached_property
    def neighbours(self) -> IntArray:
        """Number of agents within talking distance before the move, (T, N)."""
        counts = np.zeros(self.choice.shape, dtype=np.int64)
        np.add.at(counts, (self.contacts[:, 0] - 1, self.contacts[:, 1]), 1)
        return counts
