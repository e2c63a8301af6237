"""Scripted policies of 2D worlds, and the legal moves and replies that they use."""

import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import fmean
from typing import Any

from numpy.random import Generator

from foundry.models.base import ScriptedModel
from foundry.worlds.grid.space import OFFSETS, Cell

STAY = "stay"
LEADER = "leader"
"""Value of the attribute `role` in the persona of a leader, an agent that knows all exits."""
_WARNING = re.compile(r'Fire "([^"\n]*)" at \((-?\d{1,9}), (-?\d{1,9})\), radius (\d{1,9}(?:\.\d{1,9})?)\.')
_WAYS = {way: OFFSETS[way] for way in ("right", "up", "left", "down")}
"""The directions in the order of preference; right comes first, so that agents eat the food row by row."""


def legal_moves(observation: Mapping[str, Any]) -> dict[str, Cell]:
    """Return the cell after each legal choice: `stay`, then the directions that do not leave the grid."""
    x, y, half_size = observation["x"], observation["y"], observation["half_size"]
    cells = {STAY: (x, y)} | {way: (x + dx, y + dy) for way, (dx, dy) in OFFSETS.items()}
    return {choice: cell for choice, cell in cells.items() if max(abs(cell[0]), abs(cell[1])) <= half_size}


def is_on_grid(kind: str, observation: Mapping[str, Any]) -> bool:
    """Return whether a question comes from a 2D world, whose observations have the agent's cell and the grid's size."""
    return kind in ("message", "action") and {"x", "y", "half_size"} <= observation.keys()


def any_of(choices: list[str], rng: Generator) -> str:
    """Return a random choice; all are equally likely."""
    return choices[int(rng.integers(len(choices)))]


def towards(observation: Mapping[str, Any], x: float, y: float, rng: Generator) -> str:
    """Return the legal choice that leads closest to a point, or a random one of several equally good choices."""
    gaps = {choice: math.dist(cell, (x, y)) for choice, cell in legal_moves(observation).items()}
    nearest = min(gaps.values())
    return any_of([choice for choice, gap in gaps.items() if gap <= nearest + 1e-9], rng)


def act(choice: str, *, memory: str = "", reasoning: str) -> str:
    """Return the reply that chooses `choice` (`stay` or a direction) in an action question."""
    action = {"action": STAY} if choice == STAY else {"action": "move", "direction": choice}
    return json.dumps({**action, "memory": memory, "reasoning": reasoning}, ensure_ascii=False)


def say(text: str | None, *, reasoning: str) -> str:
    """Return the reply to a message question; the text None means silence."""
    return json.dumps({"message": text, "reasoning": reasoning}, ensure_ascii=False)


class Echo(ScriptedModel):
    """Walks at random, and repeats the last message that it received; before the first one, it says its own number."""

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Repeat the last message."""
        received = observation["received"]
        text = received[-1]["text"] if received else f"I am Agent {observation['agent']}."
        return say(text, reasoning="I repeat what I hear.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Draw a legal action."""
        return act(any_of(list(legal_moves(observation)), rng), reasoning="A draw among the legal actions.")


class Herd(ScriptedModel):
    """Goes to the centroid of its neighbours and says how many there are; without neighbours, it walks at random."""

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say the number of neighbours."""
        near = len(observation["neighbours"])
        text = f"I am with {near} others. Let us stay together." if near else None
        return say(text, reasoning="I speak when somebody is near.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Move one cell towards the neighbours; without neighbours, in a random direction."""
        neighbours = observation["neighbours"]
        if not neighbours:
            return act(any_of(list(legal_moves(observation)), rng), reasoning="I look for others.")
        x, y = fmean(other["x"] for other in neighbours), fmean(other["y"] for other in neighbours)
        return act(towards(observation, x, y, rng), reasoning="I join the others.")


class Seek(ScriptedModel):
    """Takes a shortest path to the nearest place and stays there; it says which place it is in, or goes to."""

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Send a message with the place where the agent is or, outside all places, the place to which it goes."""
        if observation["place"]:
            return say(f"I am in {observation['place']['name']}.", reasoning="Others may want to know.")
        goal = _nearest(observation)
        text = f"I am going to {goal['name']}." if goal else None
        return say(text, reasoning="I tell where I go, when I go anywhere.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Step towards the nearest place, or stay in it."""
        if observation["place"]:
            return act(STAY, memory=f"I am in {observation['place']['name']}.", reasoning="I have arrived.")
        goal = _nearest(observation)
        if goal is None:
            return act(STAY, reasoning="There is no place to go to.")
        choice = towards_place(observation, rng)
        return act(choice, memory=f"I am going to {goal['name']}.", reasoning="It is the nearest place.")


def towards_place(observation: Mapping[str, Any], rng: Generator) -> str:
    """Return a step on a shortest path to the nearest place; `stay` inside a place, or if there are no places."""
    goal = _nearest(observation)
    if observation["place"] or goal is None:
        return STAY
    return towards(observation, *_entrance(goal, observation), rng)


def _nearest(observation: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Return the place with the shortest path; if several are equally near, the first of them."""

    def path(place: Mapping[str, Any]) -> int:
        x, y = _entrance(place, observation)
        return abs(x - int(observation["x"])) + abs(y - int(observation["y"]))

    return min(observation["places"], key=path, default=None)


def _entrance(place: Mapping[str, Any], observation: Mapping[str, Any]) -> Cell:
    """Return the place's cell that is nearest to the agent."""
    x = min(max(observation["x"], place["x_min"]), place["x_max"])
    y = min(max(observation["y"], place["y_min"]), place["y_max"])
    return x, y


@dataclass(frozen=True, slots=True)
class _Fire:
    name: str
    x: int
    y: int
    radius: float

    def gap(self, cell: Cell) -> float:
        """Distance from a cell to the edge of the fire's radius, in cells; negative for a cell inside the radius."""
        return math.dist(cell, (self.x, self.y)) - self.radius

    def __str__(self) -> str:
        return f'Fire "{self.name}" at ({self.x}, {self.y}), radius {self.radius:g}.'


class Avoid(ScriptedModel):
    """Stays out of the radius of every fire that it knows, and repeats warnings to its neighbours.

    The agent also stores warnings in its memory, because it forgets messages earlier than memories.
    """

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Warn the neighbours of all fires that it knows."""
        return warn(observation)

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Walk at random outside the radii of all fires, or leave the radius of a fire."""
        fires = _known_fires(observation)
        memory = known_fires(observation)
        cells = legal_moves(observation)
        gaps = {choice: min((fire.gap(cell) for fire in fires), default=1.0) for choice, cell in cells.items()}
        outside = [choice for choice, gap in gaps.items() if gap > 0]
        if outside:
            return act(any_of(outside, rng), memory=memory, reasoning="No fire reaches there.")
        furthest = max(gaps.values())
        choices = [choice for choice, gap in gaps.items() if gap >= furthest - 1e-9]
        return act(any_of(choices, rng), memory=memory, reasoning="It leads away from the fire.")


def warn(observation: Mapping[str, Any]) -> str:
    """Return the reply that warns the neighbours of all known fires; without fires or neighbours, a silent reply."""
    if not _known_fires(observation) or not observation["neighbours"]:
        return say(None, reasoning="There is nothing to warn of, or nobody to warn.")
    return say("Warning: " + known_fires(observation), reasoning="Others may not perceive it.")


def known_fires(observation: Mapping[str, Any]) -> str:
    """Return a text with all known fires, as scripted policies write it in messages and memories."""
    return " ".join(map(str, _known_fires(observation)))


def _known_fires(observation: Mapping[str, Any]) -> list[_Fire]:
    """Return the fires that an agent perceives, remembers or was warned of, each once, sorted by name and position."""
    known = {_Fire(fire["name"], fire["x"], fire["y"], fire["radius"]) for fire in observation["fires"]}
    texts = [*observation["memory"], *(heard["text"] for heard in observation["received"])]
    for text in texts:
        for name, x, y, radius in _WARNING.findall(text):
            known.add(_Fire(name, int(x), int(y), float(radius)))
    return sorted(known, key=lambda fire: (fire.name, fire.x, fire.y, fire.radius))


class ShortestPath(ScriptedModel):
    """Takes a shortest route to its exit in the fastest evacuation of all agents, and says nothing.

    The policy reads `ways_out` of `Question.secret`, which models never see. An agent without a route stays in its
    cell.
    """

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say nothing."""
        return say(None, reasoning="I am busy leaving.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Move to a random one of the next cells that lie on a shortest way out."""
        ways = observation.get("ways_out") or [STAY]
        return act(any_of(ways, rng), reasoning="It is on a shortest way out.")


class FollowLeader(ScriptedModel):
    """Goes to the nearest visible leader, or else by a shortest route to the nearest known exit; warns of fires.

    Leaders, and agents that see an exit, follow nobody. An agent without leader and exit walks at random. The policy
    reads `ways_known` of `Question.secret`, which models never see.
    """

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Warn the neighbours of all fires that it knows."""
        return warn(observation)

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Move one cell towards a leader or an exit."""
        ways, why = _followed(observation)
        choices = ways or list(observation.get("open") or [STAY])
        return act(any_of(choices, rng), memory=known_fires(observation), reasoning=why)


def _followed(observation: Mapping[str, Any]) -> tuple[list[str], str]:
    """Return the open directions towards a leader or an exit, and the reason; no directions if it knows neither."""
    leads = observation["persona"].get("role") == LEADER
    leaders = [agent for agent in observation.get("seen") or () if agent["persona"].get("role") == LEADER]
    if leads or not leaders or any(exit_seen["seen"] for exit_seen in observation.get("exits") or ()):
        return list(observation.get("ways_known") or ()), "It is on the way to the nearest exit that I know of."
    x, y = observation["x"], observation["y"]
    leader = min(leaders, key=lambda agent: (abs(agent["x"] - x) + abs(agent["y"] - y), agent["id"]))
    return _nearer(observation, leader["x"] - x, leader["y"] - y), f"I follow Agent {leader['id']}."


def _nearer(observation: Mapping[str, Any], dx: int, dy: int) -> list[str]:
    """Return the open directions that lead closer to a point which is dx columns and dy rows away."""
    wanted = {"right": dx > 0, "left": dx < 0, "up": dy > 0, "down": dy < 0}
    return [way for way in observation["open"] if wanted[way]]


class Forager(ScriptedModel):
    """Reproduces if it can; if not, gathers the food in its cell; without food there, goes to the nearest visible food.

    Of equally near cells with food it prefers the one with the most food, then the one to the right, above, to the
    left, below. An agent that sees no food walks at random. It says nothing.
    """

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say nothing."""
        return say(None, reasoning="I mind my own business.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Reproduce if possible; else gather food, or go to food."""
        x, y, food = observation["x"], observation["y"], observation.get("food") or ()
        birth = observation.get("reproduction")
        if birth is not None and observation["energy"] >= birth["needs"]:
            return _do("reproduce", reasoning="I have enough for two.")
        if not food:
            choices = list(observation.get("open") or legal_moves(observation))
            return act(any_of(choices, rng), reasoning="I look for food.")
        offsets = [(portion["x"] - x, portion["y"] - y, portion["amount"]) for portion in food]
        dx, dy, _ = min(
            offsets, key=lambda offset: (abs(offset[0]) + abs(offset[1]), -offset[2], _rank(offset[0], offset[1]))
        )
        if dx == dy == 0:
            return _do("gather", reasoning="There is food here.")
        ways = [way for way, (right, up) in _WAYS.items() if right * dx > 0 or up * dy > 0]
        open_way = next((way for way in ways if way in observation["open"]), None)
        return act(open_way or any_of(list(observation["open"]), rng), reasoning="There is food over there.")


class Sharer(Forager):
    """A forager that gives energy to an agent within reach if it has more than enough.

    Attributes:
        enough: the agent gives energy if it has more than this.
        gift: units of energy that the agent gives.
    """

    def __init__(self, name: str, enough: int = 25, gift: int = 5) -> None:
        super().__init__(name, enough=enough, gift=gift)
        self._enough, self._gift = enough, gift

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Share energy with an agent within reach; if there is none, or too little energy, look for food."""
        touchable = observation.get("touchable") or ()
        if touchable and observation["energy"] is not None and observation["energy"] > self._enough:
            target = touchable[int(rng.integers(len(touchable)))]
            return _do("share", target=target, amount=self._gift, reasoning="I have more than I need.")
        return super().action(observation, rng)


class Fighter(Forager):
    """A forager that attacks agents within reach."""

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Attack an agent within reach, or else forage."""
        touchable = observation.get("touchable") or ()
        if touchable and observation["energy"] is not None:
            target = touchable[int(rng.integers(len(touchable)))]
            return _do("attack", target=target, reasoning="What is theirs can be mine.")
        return super().action(observation, rng)


def _rank(dx: int, dy: int) -> int:
    """Return the rank of the most preferred direction that leads towards an offset; a smaller rank is preferred."""
    return next((rank for rank, (right, up) in enumerate(_WAYS.values()) if right * dx > 0 or up * dy > 0), len(_WAYS))


def _do(action: str, *, reasoning: str, **further: int) -> str:
    return json.dumps({"action": action, **further, "memory": "", "reasoning": reasoning})
