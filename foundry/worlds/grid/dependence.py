"""Which agents of a 2D world can be asked before the others have answered: those whom nobody behind them can reach.

An agent's question depends on who stands where at its step, as far as that is perceived: on the others within
`communication_distance` in its area, on how many are at its place, and on what its neighbours have said. An agent moves
by one cell a step at most. So whoever is some steps behind stands, by then, within so many cells of where it is now (in
Manhattan distance), and an agent that none of these can reach perceives the same whatever they decide. This is the rule
of conservative discrete-event simulation; for agents of language models: Xie et al., AI Metropolis, arXiv:2411.03519.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, TypeAlias

import msgspec
import numpy as np

from foundry.worlds.base import Ahead, Answer, Asked, Question
from foundry.worlds.grid.grid_observation import ACTION, MESSAGE, Perception, question
from foundry.worlds.grid.grid_settings import GridSettings, History
from foundry.worlds.grid.parsing import MessageReading, Readings
from foundry.worlds.grid.space import OUTSIDE, BoolArray, Cell, Fire, IntArray, Place

Target: TypeAlias = Callable[[Cell, str | None], Cell]
"""Says where a move in a direction leads, or None."""

MOST_STEPS = 32
"""Steps that an agent is ahead of another at most; more of them hardly ever help."""

MOST_WAITING = 20_000
"""Answers that wait in memory for the slowest at most, where these are of several steps; a few KB each."""

_UNKNOWN = -2
"""Stands for the area of those who have not come to a step yet; another one than every area, OUTSIDE included."""

_KNOWN: dict[type[msgspec.Struct], str] = {
    GridSettings: (
        "name half_size agents steps places fires personas layout communication_distance history draw_positions "
        "tell_fires"
    ),
    Place: "name type center extent capacity",
    Fire: "name start position intensity radius",
    History: "memory messages",
}
"""The settings that the rule was made for."""


def is_known(settings: GridSettings) -> bool:
    """Return whether a world has nothing that the rule was not made for: no further setting that says anything."""
    parts = (settings, settings.history, *settings.places, *settings.fires)
    return all(
        one.name in _KNOWN.get(type(part), "").split() or getattr(part, one.name) == one.default
        for part in parts
        for one in _fields(type(part))
    )


_fields = cache(msgspec.structs.fields)
"""The settings of a part, which take msgspec a while to tell."""


def can_come_near(offsets: IntArray, steps: IntArray, reach: float) -> BoolArray:
    """Return who can come within reach of a cell in so many steps.

    Args:
        offsets: from the cell to each of them, (n, 2).
        steps: how many each has left, (n,).
        reach: Euclidean distance, cells.

    The cells that can be reached lie in a square on its corner, |x| + |y| <= steps; what is asked is whether the
    nearest point of it is within reach.
    """
    away = np.abs(offsets)
    beyond = np.maximum(away.sum(axis=1) - steps, 0)
    aside = np.minimum(away.min(axis=1), beyond / 2)  # as far as the side goes; then comes its corner
    squared = aside**2 + (beyond - aside) ** 2
    # A hair more than asked, so that rounding never lets go of anyone.
    return np.asarray(squared <= reach * reach * (1 + 1e-9))


def can_enter(cells: IntArray, steps: IntArray, place: Place) -> BoolArray:
    """Return who can be in a place after so many steps; cells (n, 2), steps (n,)."""
    low, high = np.array([place.x_min, place.y_min]), np.array([place.x_max, place.y_max])
    away = np.maximum(low - cells, 0) + np.maximum(cells - high, 0)
    return np.asarray(away.sum(axis=1) <= steps)


@dataclass
class Kept:
    """What an agent keeps, oldest first; each as long as the world's own."""

    memories: deque[str]
    received: deque[dict[str, Any]]

    def __post_init__(self) -> None:
        self.memories, self.received = self.memories.copy(), self.received.copy()


@dataclass
class _Moment:
    """What is known of a step so far.

    Attributes:
        cells: where each agent is, (n, 2).
        areas: the area of each, (n,); _UNKNOWN before it has come to this step.
        near: whom those who were asked can talk to.
        perceived: their observations, until they are asked for an action.
        said: their messages.
        unheard: how many of itself and its neighbours have still to say what they have to say, by agent.
        acted: how many have decided.
    """

    cells: IntArray
    areas: IntArray
    near: dict[int, list[int]] = field(default_factory=dict)
    perceived: dict[int, dict[str, Any]] = field(default_factory=dict)
    said: dict[int, MessageReading] = field(default_factory=dict)
    unheard: dict[int, int] = field(default_factory=dict)
    acted: int = 0


class GridAhead(Ahead):
    """Knows of each agent at which step it is, and who has to wait for whom."""

    def __init__(
        self,
        settings: GridSettings,
        perception: Perception,
        target: Target,
        step: int,
        cells: Sequence[Cell],
        kept: Sequence[Kept],
        readings: Readings,
    ) -> None:
        """Begin at a step, before its messages.

        Args:
            settings: the configured world.
            perception: its own.
            target: its rule of moving.
            step: the step that comes, from 1.
            cells: where each agent is then.
            kept: what each agent keeps then.
            readings: its readings of replies.
        """
        self._settings, self._perception, self._target = settings, perception, target
        self._kept, self._readings = kept, readings
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
        """Return what can be asked now: messages of whom nobody can reach, actions of who has heard all."""
        asked = [self._ask_action(agent) for agent in self._to_act]
        for agent in self._to_look_at:
            holder = self._holder(agent)
            if holder is None:
                asked.append(self._ask_message(agent))
            else:
                self._waiting_for.setdefault(holder, []).append(agent)
        self._to_look_at, self._to_act = [], []
        return asked

    def take(self, asked: Asked, answer: Answer) -> None:
        """Take an agent's message or its action."""
        step, agent, kind = asked
        if kind == MESSAGE:
            self._take_message(self._moments[step], agent, answer)
        else:
            self._take_action(self._moments[step], agent, answer)

    def next_round(self) -> Sequence[Asked]:
        """Return the messages, or the actions, of a step once all agents have decided them."""
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
        """Return the one furthest behind of those that may still come near an agent, or None."""
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
        moment, kept = self._moments[step], self._kept[agent]
        near, perceived = self._perception.observe_one(step, agent, moment.cells, moment.areas)
        moment.near[agent], moment.perceived[agent] = near.tolist(), perceived
        moment.unheard[agent] = 1 + sum(other not in moment.said for other in moment.near[agent])
        return question(perceived, kept.memories, kept.received, None)

    def _ask_action(self, agent: int) -> Question:
        moment, kept = self._moments[int(self._steps[agent])], self._kept[agent]
        for sender in moment.near[agent]:
            text = moment.said[sender].text
            if text is not None:
                kept.received.append({"sender": sender, "text": text})
        return question(moment.perceived.pop(agent), kept.memories, kept.received, moment.said[agent])

    def _take_message(self, moment: _Moment, agent: int, answer: Answer) -> None:
        moment.said[agent] = self._readings.messages.ahead(answer)
        for hearer in (agent, *moment.near[agent]):
            if hearer in moment.unheard:
                moment.unheard[hearer] -= 1
                if not moment.unheard[hearer]:
                    self._to_act.append(hearer)

    def _take_action(self, moment: _Moment, agent: int, answer: Answer) -> None:
        action = self._readings.actions.ahead(answer)
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
