"""Observations and questions of agents, and the delivery of messages.

The list below names the keys of an observation. Lists are in the order of the configuration unless stated otherwise.

- `agent`: the agent's id, from 0.
- `step`: the number of the step, from 1.
- `persona`: the agent's attributes and their values.
- `x`, `y`: the agent's cell.
- `half_size`: both axes run from -half_size to +half_size.
- `place_types`: the types of the places, each once; their order in the paper is arbitrary.
- `place`: the agent's place, `{name, type, agents, capacity, occupancy_rate}`; null outside all places. The value of
  `agents` is the number of agents in the place, including the agent itself.
- `fires`: the fires that the agent perceives, `[{name, x, y, intensity, radius, distance}]`.
- `places`: all places, `[{name, type, x, y, x_min, x_max, y_min, y_max, capacity}]`.
- `neighbours`: the agents that it can talk to, by ascending id, `[{id, x, y, persona, place: null or {name, type}}]`.
- `memory`: the agent's own memories, oldest first.
- `received`: messages from other agents, oldest first, `[{sender, text}]`. Messages of step t are in the action
  question of step t and in the message question of step t + 1.
- `message`: the agent's own message in this step, or null; only in the action question.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from foundry.records import Message
from foundry.worlds.base import Question
from foundry.worlds.grid.grid_settings import GridSettings
from foundry.worlds.grid.parsing import ActionReading, MessageReading
from foundry.worlds.grid.space import (
    OUTSIDE,
    Cell,
    IntArray,
    Place,
    distances,
    fires_perceived_at,
    neighbours,
    perceived_fires,
)


@dataclass(frozen=True, slots=True)
class Scene:
    """The perceptions of all present agents in one step; every sequence has one element per agent, sorted by id.

    Attributes:
        areas: index of the place of each agent, or OUTSIDE.
        fires: names of the fires that each agent perceives.
        neighbours: ids of the agents that each agent can talk to.
        observations: the observations, without the keys `memory`, `received` and `message`.
    """

    areas: Sequence[int]
    fires: Sequence[tuple[str, ...]]
    neighbours: Sequence[tuple[int, ...]]
    observations: Sequence[dict[str, Any]]

    def step_of(
        self, index: int, cell: Cell, arrived: Cell, message: MessageReading, action: ActionReading
    ) -> dict[str, Any]:
        """Return an agent's record of a step as a dict, without the number of the step, the agent's id and its place.

        Args:
            index: index of the agent in the sequences of this scene.
            cell: the agent's cell before the move.
            arrived: the agent's cell after the move.
            message: the agent's message.
            action: the agent's decision.
        """
        return {
            "x": cell[0],
            "y": cell[1],
            "x_next": arrived[0],
            "y_next": arrived[1],
            "fires": self.fires[index],
            "neighbours": self.neighbours[index],
            "message": message.text,
            "action": action.action,
            "direction": action.direction,
            "moved": arrived != cell,
            "memory": action.memory,
            "reasoning": action.reasoning,
            "message_reasoning": message.reasoning,
            "outcome": action.outcome,
            "message_outcome": message.outcome,
        }


class Perception:
    """Makes the observations of one configured world; their constant parts are made once and shared."""

    def __init__(self, settings: GridSettings, personas: Sequence[dict[str, str]]) -> None:
        self._settings = settings
        self._personas = personas
        self._field = settings.field
        self._told = settings.fires if settings.tell_fires else ()
        self._seen_places = [{"name": place.name, "type": place.type} for place in settings.places]
        self._fixed: dict[str, Any] = {
            "half_size": settings.half_size,
            "place_types": list(dict.fromkeys(place.type for place in settings.places)),
            "places": [_describe(place) for place in settings.places],
        }

    def observe(self, step: int, cells: Sequence[Cell]) -> Scene:
        """Return the scene at a step, with the agents on these cells."""
        return self._observe(step, range(len(cells)), cells)

    def _observe(
        self, step: int, ids: Sequence[int], cells: Sequence[Cell], burning: Mapping[str, IntArray] | None = None
    ) -> Scene:
        """Return the scene at a step; `ids` is ascending, and `cells` has the same order."""
        grid = np.array(cells, dtype=np.int64)
        area_of = self._field.areas(grid)
        near = self._near(grid, area_of)
        fires = perceived_fires(self._told, step, grid, burning)
        areas = area_of.tolist()
        visited = {area: self._visited(area, areas.count(area)) for area in set(areas)}
        seen = [self._seen(agent, cell, area) for agent, cell, area in zip(ids, cells, areas, strict=True)]
        observations = [
            self._perceived(step, me, visited[area], fires[index], [seen[other] for other in near[index]])
            for index, (me, area) in enumerate(zip(seen, areas, strict=True))
        ]
        names = [tuple(fire["name"] for fire in perceived) for perceived in fires]
        heard = near if len(ids) == len(self._personas) else [tuple(ids[other] for other in own) for own in near]
        return Scene(areas, names, heard, observations)

    def _near(self, cells: IntArray, areas: IntArray) -> Sequence[tuple[int, ...]]:
        """Return each agent's neighbours, as row numbers of `cells` (n, 2); `areas` is (n,)."""
        return neighbours(cells, areas, self._settings.communication_distance)

    def observe_one(self, step: int, agent: int, cells: IntArray, areas: IntArray) -> tuple[IntArray, dict[str, Any]]:
        """Return one agent's neighbours (ids) and observation, the same as `observe` returns for it.

        Args:
            step: 1-based step.
            agent: id of the agent.
            cells: cell of each agent, (n, 2).
            areas: area of each agent, (n,). An agent whose cell is unknown gets a number that no area has; such an
                agent must be out of reach and in another place.
        """
        area = int(areas[agent])
        there = np.flatnonzero(areas == area)
        is_near = distances(cells[there], cells[agent]) <= self._settings.communication_distance
        near = there[is_near & (there != agent)]
        x, y = cells[agent].tolist()
        fires = fires_perceived_at((x, y), self._told, step)
        visited = self._visited(area, len(there))
        me = self._seen(agent, (x, y), area)
        met = [
            self._seen(other, (u, v), area) for other, (u, v) in zip(near.tolist(), cells[near].tolist(), strict=True)
        ]
        return near, self._perceived(step, me, visited, fires, met)

    def _perceived(
        self,
        step: int,
        me: dict[str, Any],
        place: dict[str, Any] | None,
        fires: list[dict[str, Any]],
        met: list[dict[str, Any]],
    ) -> dict[str, Any]:
        return {
            "agent": me["id"],
            "step": step,
            "persona": me["persona"],
            "x": me["x"],
            "y": me["y"],
            **self._fixed,
            "place": place,
            "fires": fires,
            "neighbours": met,
        }

    def _seen(self, agent: int, cell: Cell, area: int) -> dict[str, Any]:
        """Return the data about an agent that the agent's neighbours observe."""
        place = None if area == OUTSIDE else self._seen_places[area]
        return {"id": agent, "x": cell[0], "y": cell[1], "persona": self._personas[agent], "place": place}

    def _visited(self, area: int, agents: int) -> dict[str, Any] | None:
        """Return the facts that agents in a place observe about this place; None outside all places."""
        if area == OUTSIDE:
            return None
        place = self._settings.places[area]
        return {
            "name": place.name,
            "type": place.type,
            "agents": agents,
            "capacity": place.capacity,
            "occupancy_rate": agents / place.capacity,
        }


def _describe(place: Place) -> dict[str, Any]:
    return {
        "name": place.name,
        "type": place.type,
        "x": place.center[0],
        "y": place.center[1],
        "x_min": place.x_min,
        "x_max": place.x_max,
        "y_min": place.y_min,
        "y_max": place.y_max,
        "capacity": place.capacity,
    }


MESSAGE, ACTION = "message", "action"
IDLE = {
    MESSAGE: json.dumps({"message": None, "reasoning": "I keep to myself."}),
    ACTION: json.dumps({"action": "stay", "memory": "", "reasoning": "I stay where I am."}),
}
"""The reply that does nothing, by kind of question."""


def question(
    perceived: dict[str, Any],
    memories: Iterable[str],
    received: Iterable[dict[str, Any]],
    said: MessageReading | None,
) -> Question:
    """Return the message question of an agent, or its action question if it has already given its message.

    Args:
        perceived: the agent's observation in this step, without memories and messages.
        memories: the agent's memories, oldest first.
        received: messages from others, oldest first.
        said: the agent's message in this step; None before the agent has given one.
    """
    observation = perceived | {"memory": list(memories), "received": list(received)}
    if said is not None:
        observation["message"] = said.text
    kind = MESSAGE if said is None else ACTION
    return Question(perceived["step"], perceived["agent"], kind, observation, idle=IDLE[kind])


def deliveries(
    step: int, said: Iterable[tuple[int, MessageReading]], neighbours: Iterable[Iterable[int]]
) -> list[Message]:
    """Return the delivered messages of a step, sorted by sender and recipient.

    Args:
        step: 1-based step.
        said: senders with their messages; a silent sender reaches nobody.
        neighbours: recipients of each sender, in the order of the senders.
    """
    return [
        Message(step=step, sender=sender, recipient=recipient, text=reading.text)
        for (sender, reading), hearers in zip(said, neighbours, strict=True)
        if reading.text is not None
        for recipient in hearers
    ]


def heard(message: Message) -> dict[str, Any]:
    """Convert a delivered message to an entry in the recipient's observation."""
    return {"sender": message.sender, "text": message.text}
