"""Finds agents of a 2D world that can be asked already, although other agents have not completed earlier steps.

An agent's question depends on its neighbours' cells and messages, and on the number of agents in its place. An agent
moves by at most one cell per step. So an agent that lags n steps behind will then be at most n cells away from its
present cell (Manhattan distance). If no lagging agent can come near agent A within these n steps, A's next question is
known, and foundry asks it early. Conservative discrete-event simulation also runs ahead only where no late event can
interfere. For agents played by language models, see Xie et al., AI Metropolis, arXiv:2411.03519.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, TypeAlias

import msgspec
import numpy as np

from foundry.worlds.base import Ahead, Answer, Question, QuestionKey
from foundry.worlds.grid.grid_observation import ACTION, MESSAGE, Perception, question
from foundry.worlds.grid.grid_settings import GridSettings, History
from foundry.worlds.grid.parsing import MessageReading, read_action, read_message
from foundry.worlds.grid.space import OUTSIDE, BoolArray, Cell, Fire, IntArray, Place

Target: TypeAlias = Callable[[Cell, str | None], Cell]
"""A function that returns the cell after a move in a direction; the direction None means staying."""

MOST_STEPS = 32
"""Maximum number of steps by which an agent may be ahead of the slowest one; larger values hardly save time."""

MOST_WAITING = 20_000
"""Maximum number of answers that wait in memory for the slowest agent; each takes a few KB."""

_UNKNOWN = -2
"""Number in place of an area, for an agent whose step is not played yet; it differs from OUTSIDE and every area."""

_KNOWN: dict[type[msgspec.Struct], str] = {
    GridSettings: (
        "name half_size agents steps places fires personas layout communication_distance history draw_positions "
        "tell_fires"
    ),
    Place: "name type center extent capacity",
    Fire: "name start position intensity radius",
    History: "memory messages",
}
"""Names of settings, by class, with which agents can be asked early."""


def is_known(settings: GridSettings) -> bool:
    """Return whether agents can be asked early: only the settings in `_KNOWN` may differ from their defaults."""
    parts = (settings, settings.history, *settings.places, *settings.fires)
    return all(
        field.name in _KNOWN.get(type(part), "").split() or getattr(part, field.name) == field.default
        for part in parts
        for field in _fields(type(part))
    )


_fields = cache(msgspec.structs.fields)
"""Lists the settings of a class; cached, since msgspec needs time for it."""


def can_come_near(offsets: IntArray, steps: IntArray, reach: float) -> BoolArray:
    """Return whether each agent can come within reach of a cell in its remaining steps, (n,).

    The reachable cells form a square standing on its corner, |x| + |y| <= steps. The result says whether the nearest
    point of this square is within reach.

    Args:
        offsets: offset of each agent from the cell, (n, 2).
        steps: number of steps that each agent may still take, (n,).
        reach: Euclidean distance in cells.
    """
    away = np.abs(offsets)
    beyond = np.maximum(away.sum(axis=1) - steps, 0)
    aside = np.minimum(away.min(axis=1), beyond / 2)  # along the side, up to its corner
    squared = aside**2 + (beyond - aside) ** 2
    # Slightly more than `reach`, so that rounding never excludes an agent.
    return np.asarray(squared <= reach * reach * (1 + 1e-9))


def can_enter(cells: IntArray, steps: IntArray, place: Place) -> BoolArray:
    """Return whether each agent can enter a place in its remaining steps, (n,); cells (n, 2), steps (n,)."""
    low, high = np.array([place.x_min, place.y_min]), np.array([place.x_max, place.y_max])
    away = np.maximum(low - cells, 0) + np.maximum(cells - high, 0)
    return np.asarray(away.sum(axis=1) <= steps)


@dataclass
class AgentMemory:
    """A copy of an agent's memories and received messages, oldest first; each list has the world's maximum length."""

    memories: deque[str]
    received: deque[dict[str, Any]]

    def __post_init__(self) -> None:
        self.memories, self.received = self.memories.copy(), self.received.copy()


@dataclass
class _Moment:
    """The known part of the world's state in one step; a few agents may not have played this step yet.

    Attributes:
        cells: cell of each agent, (n, 2).
        areas: area of each agent, (n,); _UNKNOWN before the agent reaches this step.
        near: neighbours of each agent that was asked for a message.
        perceived: observation of each agent, until the agent is asked for an action.
        unheard: number of messages that an agent still waits for, including its own.
        acted: number of agents that have decided on an action.
    """

    cells: IntArray
    areas: IntArray
    near: dict[int, list[int]] = field(default_factory=dict)
    perceived: dict[int, dict[str, Any]] = field(default_factory=dict)
    said: dict[int, MessageReading] = field(default_factory=dict)
    unheard: dict[int, int] = field(default_factory=dict)
    acted: int = 0


class GridAhead(Ahead):
    """Tracks which step each agent has reached, and for which other agents an agent must wait."""

    def __init__(
        self,
        settings: GridSettings,
        perception: Perception,
        target: Target,
        step: int,
        cells: Sequence[Cell],
        inputs: Sequence[AgentMemory],
    ) -> None:
        """Start at the beginning of a step, before its message questions.

        Args:
            settings: the configured world.
            perception: makes the observations of the world.
            target: returns the cell after a move.
            step: number of the next step, from 1.
            cells: cell of each agent at the beginning of that step.
            inputs: memory of each agent at the beginning of that step.
        """
        self._settings, self._perception, self._target = settings, perception, target
        self._kept = inputs
        self._cells = np.array(cells, dtype=np.int64).reshape(-1, 2)
        self._areas = settings.field.areas(self._cells)
        self._steps = np.full(len(cells), step)
        self._moments = {step: _Moment(self._cells.copy(), self._areas.copy())}
        self._round = (step, MESSAGE)
        self._to_look_at = list(range(len(cells)))
        self._to_act: list[int] = []
        self._waiting_for: dict[int, list[int]] = {}
        self._most = max(1, min(MOST_STEPS, MOST_WAITING // (2 * len(cells))))

    def ready(self) -> Sequence[Question]:
        """Return the questions that can be asked now.

        An agent is asked for a message once no agent behind can come near, and for an action once it has heard all
        messages of its step.
        """
        asked = [self._ask_action(agent) for agent in self._to_act]
        for agent in self._to_look_at:
            holder = self._holder(agent)
            if holder is None:
                asked.append(self._ask_message(agent))
            else:
                self._waiting_for.setdefault(holder, []).append(agent)
        self._to_look_at, self._to_act = [], []
        return asked

    def take(self, asked: QuestionKey, answer: Answer) -> None:
        """Take an agent's answer: its message, or its action."""
        step, agent, kind = asked
        if kind == MESSAGE:
            self._take_message(self._moments[step], agent, answer)
        else:
            self._take_action(self._moments[step], agent, answer)

    def next_round(self) -> Sequence[QuestionKey]:
        """Return step, agent and kind of each question in the next round; nothing if an answer is missing."""
        step, kind = self._round
        agents = len(self._kept)
        moment = self._moments.get(step)
        if moment is None or (len(moment.said) if kind == MESSAGE else moment.acted) < agents:
            return ()
        if kind == ACTION:
            del self._moments[step]
        self._round = (step, ACTION) if kind == MESSAGE else (step + 1, MESSAGE)
        return [(step, agent, kind) for agent in range(agents)]

    def _holder(self, agent: int) -> int | None:
        """Return the slowest of the agents that may come near, by completed steps; None if no agent may come near."""
        step = self._steps[agent]
        behind = np.flatnonzero(self._steps < step)
        if not len(behind):
            return None
        left, cells, area = step - self._steps[behind], self._cells[behind], self._areas[agent]
        if area == OUTSIDE:
            holds = can_come_near(cells - self._cells[agent], left, self._settings.communication_distance)
        else:
            holds = can_enter(cells, left, self._settings.places[area])
        holding = np.flatnonzero(holds | (left > self._most))
        return int(behind[holding[left[holding].argmax()]]) if len(holding) else None

    def _ask_message(self, agent: int) -> Question:
        step = int(self._steps[agent])
        moment, inputs = self._moments[step], self._kept[agent]
        near, perceived = self._perception.observe_one(step, agent, moment.cells, moment.areas)
        moment.near[agent], moment.perceived[agent] = near.tolist(), perceived
        moment.unheard[agent] = 1 + sum(other not in moment.said for other in moment.near[agent])
        return question(perceived, inputs.memories, inputs.received, None)

    def _ask_action(self, agent: int) -> Question:
        moment, inputs = self._moments[int(self._steps[agent])], self._kept[agent]
        for sender in moment.near[agent]:
            text = moment.said[sender].text
            if text is not None:
                inputs.received.append({"sender": sender, "text": text})
        return question(moment.perceived.pop(agent), inputs.memories, inputs.received, moment.said[agent])

    def _take_message(self, moment: _Moment, agent: int, answer: Answer) -> None:
        moment.said[agent] = read_message(answer)
        for hearer in (agent, *moment.near[agent]):
            if hearer in moment.unheard:
                moment.unheard[hearer] -= 1
                if not moment.unheard[hearer]:
                    self._to_act.append(hearer)

    def _take_action(self, moment: _Moment, agent: int, answer: Answer) -> None:
        action = read_action(answer)
        if action.is_kept:
            self._kept[agent].memories.append(action.memory)
        x, y = self._cells[agent].tolist()
        self._cells[agent] = arrived = self._target((x, y), action.direction)
        self._areas[agent] = self._settings.field.area(arrived)
        self._steps[agent] += 1
        moment.acted += 1
        self._to_look_at += self._waiting_for.pop(agent, ())
        step = int(self._steps[agent])
        if step <= self._settings.steps:
            then = self._moments.setdefault(step, _unknown(len(self._kept)))
            then.cells[agent], then.areas[agent] = self._cells[agent], self._areas[agent]
            self._to_look_at.append(agent)


def _unknown(agents: int) -> _Moment:
    return _Moment(np.zeros((agents, 2), dtype=np.int64), np.full(agents, _UNKNOWN))
