"""Scripted policies of 3D worlds, and the sentences with which they ask for motions."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from numpy.random import Generator

from foundry.errors import InputError
from foundry.models.base import ScriptedModel
from foundry.worlds.base import Question
from foundry.worlds.grid.grid_policies import act, known_fires, towards_place, warn

AIM_DEG = 2.0
"""The oracle corrects its heading or gaze only if it is off by more than this angle, degrees."""
STAY = "Stay."


def off_by(wanted_deg: float, actual_deg: float) -> float:
    """Return the turn from the actual to the wanted direction, degrees, left positive, -180..180."""
    return (wanted_deg - actual_deg + 180.0) % 360.0 - 180.0


def turn(degrees: float) -> str:
    """Return the sentence that turns the body, left positive."""
    return f"Turn {'left' if degrees > 0 else 'right'} {abs(degrees):.2f} degrees."


def gaze(degrees: float) -> str:
    """Return the sentence that turns the gaze, up positive."""
    return f"Look {'up' if degrees > 0 else 'down'} {abs(degrees):.2f} degrees."


def forward(metres: float) -> str:
    """Return the sentence that asks to move the body ahead."""
    return f"Move forward {metres:.3f} m."


class Wander(ScriptedModel):
    """At each decision, turns by a random angle or walks a random distance, with equal chances."""

    def __init__(self, name: str, max_turn_deg: float = 90.0, max_distance_m: float = 2.0) -> None:
        super().__init__(name, max_turn_deg=max_turn_deg, max_distance_m=max_distance_m)
        self._max_turn_deg, self._max_distance_m = max_turn_deg, max_distance_m

    def move(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Return a sentence that asks for the next movement."""
        if rng.random() < 0.5:
            return f"Let me look elsewhere. {turn(float(rng.uniform(-1, 1)) * self._max_turn_deg)}"
        return f"Let me go on. {forward(float(rng.uniform(0.1, 1)) * self._max_distance_m)}"


class Spin(ScriptedModel):
    """Turns left at every decision, always by `turn_deg`."""

    def __init__(self, name: str, turn_deg: float = 45.0) -> None:
        super().__init__(name, turn_deg=turn_deg)
        self._turn_deg = turn_deg

    def move(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Return a sentence that asks for the next movement."""
        return f"I look around. {turn(self._turn_deg)}"


class Knower(Spin):
    """Gives the right answers, read from `Question.secret`, to questions about a walk; asked to move, it only turns."""

    def nearer(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Return the right answer."""
        answer: str = observation["answer"]
        return answer

    side = count = order = distance = nearer


class Mumbler(ScriptedModel):
    """Says one of its sentences at random."""

    def __init__(self, name: str, sentences: Sequence[str]) -> None:
        super().__init__(name, sentences=list(sentences))
        self._sentences = tuple(sentences)

    def move(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Return a random one of the policy's sentences as the next movement."""
        return self._sentences[int(rng.integers(len(self._sentences)))]


class Oracle(ScriptedModel):
    """Takes the shortest path to its target, looks at it, then stays; in 2D worlds, goes to the nearest place.

    In 3D worlds the policy reads `way`, `near`, `reached`, `target_yaw` and `target_pitch` of `Question.secret`. In 2D
    worlds it warns the neighbours of all known fires at every step.
    """

    def check(self, question: Question) -> None:
        """Reject a 3D world without a target.

        Raises:
            InputError: the world has no target.
        """
        if question.kind == "move" and not question.told["target"]:
            raise InputError(
                f"Model '{self.name}' goes to a target, but the world has none. Set world.targets, or choose another "
                "policy, such as model=scripted/wander."
            )

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Warn the neighbours of all fires that it knows."""
        return warn(observation)

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Step towards the nearest place, or stay in it; remember the fires."""
        reasoning = "It is on a shortest path to the nearest place."
        return act(towards_place(observation, rng), memory=known_fires(observation), reasoning=reasoning)

    def move(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Return a sentence that asks for the next movement."""
        return f"I know where the {observation['target']} is. {_next(observation)}"


def _next(observation: Mapping[str, Any]) -> str:
    if observation["reached"]:
        return STAY
    if observation["near"] or not observation["way"]:
        return _look(observation)
    x, y = observation["way"][0]
    distance = math.hypot(x - observation["x"], y - observation["y"])
    aside = off_by(math.degrees(math.atan2(y - observation["y"], x - observation["x"])), observation["yaw"])
    # The aim is finer if the next corner is farther away, so that a long leg ends at its corner.
    if abs(aside) > min(AIM_DEG, math.degrees(0.02 / max(distance, 0.02))):
        return turn(aside)
    return forward(min(distance, observation["limits"]["max_distance_m"] or distance))


def _look(observation: Mapping[str, Any]) -> str:
    aside = off_by(observation["target_yaw"], observation["yaw"])
    if abs(aside) > AIM_DEG:
        return turn(aside)
    above = observation["target_pitch"] - observation["pitch"]
    return gaze(above) if abs(above) > AIM_DEG else STAY
