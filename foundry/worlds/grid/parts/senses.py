"""Observations in a 2D world with parts such as walls, exits and energy.

An observation has the keys of all 2D worlds (`foundry.worlds.grid.grid_observation`), and the keys below. The keys of a
part that the world lacks, such as energy, are empty or null:

- `view`: the number of columns and rows that the agent sees to each side; null for the whole grid.
- `window`: the cells that the agent sees, one text per row, the uppermost first. Each cell is one character: `@` the
  agent itself, `A` another agent, `#` a wall or beyond the edge, `E` an exit, `*` a burning cell, `f` food, `.` empty,
  `?` hidden by a wall.
- `open`: the directions without a wall or edge, out of `up`, `down`, `left` and `right`.
- `exits`: the exits that the agent knows, `[{name, x, y, seen, agents}]`. The position is the exit's cell that is
  nearest to the agent. The flag `seen` says whether the agent sees a cell of the exit now. The number `agents` counts
  the other agents that the agent sees within two columns and rows of the exit; `agents` is null if the agent does not
  see the exit.
- `burning`: the burning cells that the agent sees, `[[x, y]]`.
- `seen`: the other agents that it sees, even if it cannot talk to them, by id, `[{id, x, y, persona}]`.
- `zones`: all zones, `[{name, x_min, x_max, y_min, y_max, risk}]`.
- `order`: the instruction to all agents; null before its first step.
- `energy`: the agent's energy.
- `loss`: the energy that each step costs.
- `attack`: the energy that an attack takes, and the energy that it costs, `{takes, cost}`.
- `reproduction`: the energy that a parent needs, and the energy that its newborn gets, `{needs, gives}`.
- `food`: the food that the agent sees, `[{x, y, amount}]`.
- `deeds`: the actions of this world besides staying and moving, out of `gather`, `share`, `attack` and `reproduce`.
- `touchable`: the ids of the agents that it can share with or attack, at most one column and row away.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec
import numpy as np

from foundry.worlds.grid.grid_observation import Perception, Scene
from foundry.worlds.grid.grid_settings import GridSettings
from foundry.worlds.grid.parts.parts_settings import Exit, Zone
from foundry.worlds.grid.parts.terrain import Ground, SpreadingFires
from foundry.worlds.grid.space import Cell, IntArray, neighbours

NEAR_AN_EXIT = 2
"""An agent counts as at an exit if it is at most this number of columns and rows away."""
TOUCH = 1
"""An agent can share with or attack another agent at most this number of columns and rows away."""


def apart(first: Cell, other: Cell) -> int:
    """Return the distance between two cells: the number of columns or rows between them, whichever is larger."""
    return max(abs(first[0] - other[0]), abs(first[1] - other[1]))


def talking(settings: GridSettings, ground: Ground, cells: IntArray, areas: IntArray) -> Sequence[tuple[int, ...]]:
    """Return for each agent the indices of the agents that it can talk to.

    Args:
        settings: the world.
        ground: the walls of the world, which may block talk.
        cells: cell of each agent, (n, 2).
        areas: area of each agent, (n,).
    """
    reach, square = settings.communication_distance, settings.communication_shape == "square"
    near = neighbours(cells, areas, reach * math.sqrt(2) * (1 + 1e-9) if square else reach)
    barred = "talk" in settings.walls_block and bool(ground.walls)
    if not square and not barred:
        return near
    at: list[Cell] = [(x, y) for x, y in cells.tolist()]

    def heard(listener: int, other: int) -> bool:
        within = not square or apart(at[listener], at[other]) <= reach
        return within and (not barred or ground.is_clear(at[listener], at[other]))

    return [tuple(other for other in others if heard(agent, other)) for agent, others in enumerate(near)]


class Senses(Perception):
    """Makes the observations of one configured world with parts such as walls, exits and energy."""

    def __init__(self, settings: GridSettings, personas: Sequence[dict[str, str]], ground: Ground) -> None:
        super().__init__(settings, personas)
        self._ground = ground
        self._barred = "sight" in settings.walls_block
        self._chars = dict.fromkeys(ground.walls, "#") | dict.fromkeys(ground.exits, "E")
        self._fixed |= {
            "view": settings.view,
            "deeds": list(settings.further_actions),
            "loss": None if settings.energy is None else settings.energy.loss,
            "attack": None if settings.attack is None else msgspec.to_builtins(settings.attack),
            "reproduction": None
            if settings.reproduction is None
            else {"needs": settings.reproduction.needs, "gives": settings.reproduction.gives},
            "zones": [_described(zone) for zone in settings.zones],
        }

    def look(
        self,
        step: int,
        bodies: Mapping[int, Cell],
        *,
        spreading_fires: SpreadingFires,
        known: Mapping[int, set[str]],
        energy: Mapping[int, int],
        food: Mapping[Cell, int],
    ) -> Scene:
        """Return the scene at `step`; each exit that an agent sees is from now on known to this agent.

        Args:
            step: 1-based step.
            bodies: cell of each present agent by id; the scene keeps this order.
            spreading_fires: the burning cells.
            known: names of the exits that each agent knows, by id.
            energy: energy of each agent by id; empty in a world without energy.
            food: units of food by cell.
        """
        ids, cells = list(bodies), list(bodies.values())
        burning = {
            fire.name: np.array([cell for cell, source in spreading_fires.cells.items() if source is fire]).reshape(
                -1, 2
            )
            for fire in self._settings.fires
        }
        scene = self._observe(step, ids, cells, burning)
        fires_told = spreading_fires.cells if self._settings.tell_fires else {}
        chars = self._chars | dict.fromkeys(food, "f") | dict.fromkeys(fires_told, "*") | dict.fromkeys(cells, "A")
        standing: dict[Cell, list[int]] = {}
        for agent, cell in bodies.items():
            standing.setdefault(cell, []).append(agent)
        order = self._settings.order
        commanded = order.text if order is not None and order.start <= step else None
        for observation, agent, cell in zip(scene.observations, ids, cells, strict=True):
            sight = self._ground.sight(cell, self._settings.view, barred=self._barred)
            seen = {place: standing[place] for place in sight.cells & standing.keys()}
            known[agent].update(self._ground.exits[place].name for place in sight.cells & self._ground.exits.keys())
            observation |= {
                "window": sight.window(chars, cell),
                "open": self._ground.ways(cell),
                "exits": [self._exit(exit_zone, cell, seen, sight.cells) for exit_zone in self._settings.exits
                          if exit_zone.name in known[agent]],
                "burning": [list(place) for place in fires_told if place in sight.cells],
                "seen": self._others(agent, seen),
                "order": commanded,
                "energy": energy.get(agent),
                "food": [{"x": x, "y": y, "amount": food[x, y]} for x, y in sorted(sight.cells & food.keys())],
                "touchable": sorted(
                    other for place, others in seen.items() if apart(place, cell) <= TOUCH for other in others
                    if other != agent
                ),
            }  # fmt: skip
        return scene

    def _near(self, cells: IntArray, areas: IntArray) -> Sequence[tuple[int, ...]]:
        return talking(self._settings, self._ground, cells, areas)

    def _others(self, agent: int, seen: Mapping[Cell, list[int]]) -> list[dict[str, Any]]:
        others = sorted((other, cell) for cell, there in seen.items() for other in there if other != agent)
        return [{"id": other, "x": x, "y": y, "persona": self._personas[other]} for other, (x, y) in others]

    def _exit(
        self, way_out: Exit, cell: Cell, seen: Mapping[Cell, list[int]], visible: frozenset[Cell]
    ) -> dict[str, Any]:
        x, y = min(way_out.cells, key=lambda place: (abs(place[0] - cell[0]) + abs(place[1] - cell[1]), place))
        is_seen = not visible.isdisjoint(way_out.cells)
        waiting = sum(len(there) - (place == cell) for place, there in seen.items() if _is_at(place, way_out.cells))
        return {"name": way_out.name, "x": x, "y": y, "seen": is_seen, "agents": waiting if is_seen else None}


def _described(zone: Zone) -> dict[str, Any]:
    (x_min, x_max), (y_min, y_max) = map(sorted, zip(*zone.corners, strict=True))
    return {"name": zone.name, "x_min": x_min, "x_max": x_max, "y_min": y_min, "y_max": y_max, "risk": zone.risk}


def _is_at(cell: Cell, cells: Iterable[Cell]) -> bool:
    return any(apart(cell, end) <= NEAR_AN_EXIT for end in cells)
