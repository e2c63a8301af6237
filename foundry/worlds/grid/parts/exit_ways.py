"""The shortest ways out, worked out when a scripted policy asks; no model is told."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

from foundry.leaving import FAR, soonest_departures
from foundry.worlds.grid.parts.parts_settings import Exit
from foundry.worlds.grid.parts.terrain import Ground
from foundry.worlds.grid.space import OFFSETS, Cell


class WayOut:
    """Which exit each agent goes by when all are to be out as soon as can be, planned once from where they start."""

    def __init__(self, ground: Ground, exits: Sequence[Exit], bodies: Mapping[int, Cell]) -> None:
        self._ground = ground
        self._exits = exits
        self._start = dict(bodies)
        self._fields: dict[tuple[int, frozenset[Cell]], dict[Cell, int]] = {}

    def _field(self, index: int, closed: frozenset[Cell]) -> dict[Cell, int]:
        key = (index, closed)
        if key not in self._fields:
            self._fields[key] = self._ground.steps_to(self._exits[index].cells, closed)
        return self._fields[key]

    @cached_property
    def _plan(self) -> dict[int, int]:
        """The exit of each agent, by its id."""
        fields = [self._field(index, frozenset()) for index in range(len(self._exits))]
        distances = [[field.get(cell, FAR) for field in fields] for cell in self._start.values()]
        departures = soonest_departures(distances, [one.capacity for one in self._exits])
        return {agent: one.exit for agent, one in zip(self._start, departures, strict=True) if one is not None}

    def ways(self, agent: int, cell: Cell, burning: frozenset[Cell]) -> list[str]:
        """Return the directions that lie on a shortest way to the agent's exit, round what burns where there is a way.

        An agent that was not there at the start goes to the exit with the shortest way.
        """
        planned = self._plan.get(agent)
        mine = [] if planned is None else [planned]
        return self._to(mine, cell, burning) or self.ways_to({one.name for one in self._exits}, cell, burning)

    def ways_to(self, names: Collection[str], cell: Cell, burning: frozenset[Cell]) -> list[str]:
        """Return the directions that lie on a shortest way to the nearest of the exits with these names."""
        return self._to([index for index, one in enumerate(self._exits) if one.name in names], cell, burning)

    def _to(self, indices: Sequence[int], cell: Cell, burning: frozenset[Cell]) -> list[str]:
        for closed in (burning - {cell}, frozenset[Cell]()):
            fields = [field for field in (self._field(index, closed) for index in indices) if cell in field]
            if fields:
                field = min(fields, key=lambda one: one[cell])
                ends = {way: (cell[0] + dx, cell[1] + dy) for way, (dx, dy) in OFFSETS.items()}
                return [way for way, end in ends.items() if field.get(end, FAR) < field[cell]]
        return []


class Secret(Mapping[str, Any]):
    """What a policy may know and no model is told, worked out when it is asked for.

    `ways_out`: the directions on a shortest way to the exit by which all are out soonest; `ways_known`: those on a
    shortest way to the nearest exit that the agent knows of.
    """

    def __init__(
        self, plan: WayOut, agent: int, cell: Cell, *, known: Collection[str], burning: frozenset[Cell]
    ) -> None:
        self._found: dict[str, Callable[[], list[str]]] = {
            "ways_out": lambda: plan.ways(agent, cell, burning),
            "ways_known": lambda: plan.ways_to(known, cell, burning),
        }

    def __getitem__(self, key: str) -> list[str]:
        """Return directions."""
        return self._found[key]()

    def __iter__(self) -> Iterator[str]:
        """Iterate over the keys."""
        return iter(self._found)

    def __len__(self) -> int:
        """Return how many keys there are."""
        return len(self._found)
