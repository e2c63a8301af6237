"""The policy that goes to a place."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.base import ScriptedModel
from foundry.models.scripted.grid import STAY, Cell, act, say, towards


class Seek(ScriptedModel):
    """Takes a shortest path to the nearest place, stays there, and says where it is or goes."""

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Name the place."""
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
    """Return a step on a shortest path to the nearest place; stay inside it, and where there is none."""
    goal = _nearest(observation)
    if observation["place"] or goal is None:
        return STAY
    return towards(observation, *_entrance(goal, observation), rng)


def _nearest(observation: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Return the place with the shortest path; among equals the first."""

    def path(place: Mapping[str, Any]) -> int:
        x, y = _entrance(place, observation)
        return abs(x - int(observation["x"])) + abs(y - int(observation["y"]))

    return min(observation["places"], key=path, default=None)


def _entrance(place: Mapping[str, Any], observation: Mapping[str, Any]) -> Cell:
    """Return the place's cell that is nearest to the agent."""
    x = min(max(observation["x"], place["x_min"]), place["x_max"])
    y = min(max(observation["y"], place["y_min"]), place["y_max"])
    return x, y
