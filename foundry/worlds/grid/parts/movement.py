"""Who gets where when all move at once: cells and exits hold so many, and the drawn order says who is first."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from foundry.worlds.grid.parts.terrain import Ground
from foundry.worlds.grid.space import Cell


@dataclass(frozen=True, slots=True)
class Moved:
    """Where a step led.

    Attributes:
        cell: where the agent is after it; the exit's cell where it left.
        left: name of the exit by which it left, or None.
        blocked: what stopped a move that was asked for: `edge`, `wall`, `agents`, `exit`, or None.
    """

    cell: Cell
    left: str | None = None
    blocked: str | None = None


class Crossing:
    """The moves of one step.

    Whoever is first in the order gets the room that is left. An agent that stands in the way of another and moves on
    makes room for it in the same step; two cannot change places where a cell holds one.
    """

    def __init__(self, ground: Ground, capacity: int | None, cells: Mapping[int, Cell]) -> None:
        """Set the stage.

        Args:
            ground: walls and exits.
            capacity: agents that a cell holds; None for any number.
            cells: where each agent stands.
        """
        self._ground = ground
        self._capacity = capacity
        self._cells = cells
        self._held = Counter(cells.values())
        self._out: Counter[str] = Counter()

    def resolve(self, wanted: Mapping[int, Cell], order: Sequence[int]) -> dict[int, Moved]:
        """Return where each agent's step leads.

        Args:
            wanted: the cell that each agent asks to move to; those who do not move are left out.
            order: the ids of the agents that move, first come first served.
        """
        found = {agent: Moved(cell) for agent, cell in self._cells.items()}
        waiting: defaultdict[Cell, list[int]] = defaultdict(list)
        for agent in order:
            mover: int | None = agent
            while mover is not None:
                found[mover] = self._try(mover, wanted[mover])
                if found[mover].blocked == "agents":
                    waiting[wanted[mover]].append(mover)
                freed = None if found[mover].blocked else self._cells[mover]
                mover = waiting[freed].pop(0) if freed is not None and waiting[freed] else None
        return found

    def _try(self, agent: int, target: Cell) -> Moved:
        cell = self._cells[agent]
        if (stop := self._ground.stops(target)) is not None:
            return Moved(cell, blocked=stop)
        way_out = self._ground.exits.get(target)
        if way_out is not None:
            if way_out.capacity is not None and self._out[way_out.name] >= way_out.capacity:
                return Moved(cell, blocked="exit")
            self._out[way_out.name] += 1
        elif self._capacity is not None and self._held[target] >= self._capacity:
            return Moved(cell, blocked="agents")
        else:
            self._held[target] += 1
        self._held[cell] -= 1
        return Moved(target, left=None if way_out is None else way_out.name)
