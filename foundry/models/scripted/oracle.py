"""The policy that knows the way and tells all it knows: the upper bound of path efficiency and of warnings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.errors import InputError
from foundry.models.scripted.avoid import known_fires, warn
from foundry.models.scripted.base import ScriptedModel
from foundry.models.scripted.grid import act
from foundry.models.scripted.seek import towards_place
from foundry.models.scripted.spoken import AIM_DEG, STAY, forward, gaze, off_by, turn
from foundry.worlds.base import Question


class Oracle(ScriptedModel):
    """In 3D follows the shortest path to the target, looks at it, then stays; in 2D one to the nearest place.

    In 3D it reads what no model is shown: `way`, `near`, `reached`, `target_yaw` and `target_pitch`. In 2D it passes
    on, at every step, every fire that it perceived or was warned of.
    """

    def check(self, question: Question) -> None:
        """Refuse a 3D world that has nothing to be found.

        Raises:
            InputError: it has no target.
        """
        if question.kind == "move" and not question.told["target"]:
            raise InputError(
                f"Model '{self.name}' goes to a target, and the world has none: say what is to be found with "
                "world.targets, or choose another policy (scripted/wander walks about)."
            )

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Warn the neighbours of all fires it knows."""
        return warn(observation)

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Step towards the nearest place, or stay in it; remember the fires."""
        reasoning = "It is on a shortest path to the nearest place."
        return act(towards_place(observation, rng), memory=known_fires(observation), reasoning=reasoning)

    def move(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Return the next movement."""
        return f"I know where the {observation['target']} is. {_next(observation)}"


def _next(observation: Mapping[str, Any]) -> str:
    if observation["reached"]:
        return STAY
    if observation["near"] or not observation["way"]:
        return _look(observation)
    x, y = observation["way"][0]
    distance = math.hypot(x - observation["x"], y - observation["y"])
    aside = off_by(math.degrees(math.atan2(y - observation["y"], x - observation["x"])), observation["yaw"])
    # What matters on a long way is where it ends, so the aim is the finer the farther the next corner is.
    if abs(aside) > min(AIM_DEG, math.degrees(0.02 / max(distance, 0.02))):
        return turn(aside)
    return forward(min(distance, observation["limits"]["max_distance_m"] or distance))


def _look(observation: Mapping[str, Any]) -> str:
    aside = off_by(observation["target_yaw"], observation["yaw"])
    if abs(aside) > AIM_DEG:
        return turn(aside)
    above = observation["target_pitch"] - observation["pitch"]
    return gaze(above) if abs(above) > AIM_DEG else STAY
