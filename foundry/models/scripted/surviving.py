"""Policies that live on what grows in a 2D world: for themselves, for others, and on others."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.base import ScriptedModel
from foundry.models.scripted.grid import act, any_of, legal_moves, say

_WAYS = {"right": (1, 0), "up": (0, 1), "left": (-1, 0), "down": (0, -1)}
"""The order in which ways are taken that are as good as one another, so that food is grazed row by row."""


class Forager(ScriptedModel):
    """Reproduces if it can, gathers where it stands if there is food, else goes to the nearest food that it sees.

    Of equally near food it takes the most, and of equally good ways the first of right, up, left, down. Without any in
    sight it walks at random. It says nothing.
    """

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say nothing."""
        return say(None, reasoning="I mind my own business.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Gather, or go to food."""
        return _forage(observation, rng)


class Sharer(Forager):
    """A forager that gives a part of its energy to one within reach when it has more than enough.

    Attributes:
        enough: energy above which it gives.
        gift: how much it gives.
    """

    def __init__(self, name: str, enough: int = 25, gift: int = 5) -> None:
        super().__init__(name)
        self._enough, self._gift = enough, gift

    def parameters(self) -> dict[str, Any]:
        """Return the policy, when it gives, and how much."""
        return {**super().parameters(), "enough": self._enough, "gift": self._gift}

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Share with any within reach, else forage."""
        touchable = observation.get("touchable") or ()
        if touchable and observation["energy"] is not None and observation["energy"] > self._enough:
            target = touchable[int(rng.integers(len(touchable)))]
            return _do("share", target=target, amount=self._gift, reasoning="I have more than I need.")
        return _forage(observation, rng)


class Fighter(Forager):
    """A forager that attacks whoever is within reach."""

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Attack any within reach, else forage."""
        touchable = observation.get("touchable") or ()
        if touchable and observation["energy"] is not None:
            target = touchable[int(rng.integers(len(touchable)))]
            return _do("attack", target=target, reasoning="What is theirs can be mine.")
        return _forage(observation, rng)


def _forage(observation: Mapping[str, Any], rng: Generator) -> str:
    x, y, food = observation["x"], observation["y"], observation.get("food") or ()
    birth = observation.get("reproduction")
    if birth is not None and observation["energy"] >= birth["needs"]:
        return _do("reproduce", reasoning="I have enough for two.")
    if not food:
        return act(any_of(list(observation.get("open") or legal_moves(observation)), rng), reasoning="I look for food.")
    goal = min(
        food, key=lambda one: (abs(one["x"] - x) + abs(one["y"] - y), -one["amount"], _rank(one["x"] - x, one["y"] - y))
    )
    dx, dy = goal["x"] - x, goal["y"] - y
    if dx == dy == 0:
        return _do("gather", reasoning="There is food here.")
    ways = [way for way, (right, up) in _WAYS.items() if right * dx > 0 or up * dy > 0]
    chosen = next((way for way in ways if way in observation["open"]), None) or any_of(list(observation["open"]), rng)
    return act(chosen, reasoning="There is food over there.")


def _rank(dx: int, dy: int) -> int:
    """Return how late the way to a cell comes among those that are as good."""
    return next((rank for rank, (right, up) in enumerate(_WAYS.values()) if right * dx > 0 or up * dy > 0), len(_WAYS))


def _do(action: str, *, reasoning: str, **further: int) -> str:
    return json.dumps({"action": action, **further, "memory": "", "reasoning": reasoning})
