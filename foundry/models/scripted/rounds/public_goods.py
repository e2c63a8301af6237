"""Policies for public goods: who gives nothing, and who gives a share of what the others gave."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.errors import InputError
from foundry.models.scripted.base import ScriptedModel

NOBODY = json.dumps({"action": "nobody"})


def give(tokens: int) -> str:
    """Return the reply that gives so many tokens."""
    return json.dumps({"action": tokens})


class FreeRider(ScriptedModel):
    """Gives nothing and punishes nobody, as who plays for itself alone does."""

    def contribution(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Give nothing."""
        return give(0)

    def punishment(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Punish nobody."""
        return NOBODY


class Conditional(ScriptedModel):
    """Gives a share of what the others gave in the mean the round before; at first anything it has.

    What is no whole number of tokens is rounded up as often as it takes to be right in the mean. It punishes who gave
    least, of those that gave less than itself, where it is told to.

    Source: Fischbacher, Gächter and Fehr 2001 for people that give so.
    """

    def __init__(self, name: str, slope: float, punishes: bool) -> None:
        """Set how it answers.

        Args:
            name: name of the model.
            slope: tokens that it gives for each token that the others gave in the mean, 0..1.
            punishes: whether it punishes.
        """
        super().__init__(name)
        if not 0 <= slope <= 1:
            raise InputError(f"model.slope is {slope}. Give a number from 0 to 1.")
        self._slope, self._punishes = slope, punishes

    def contribution(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Follow the others."""
        had, rounds = math.floor(observation["tokens"]), observation["rounds"]
        if not rounds:
            return give(int(rng.integers(had + 1)))
        last = rounds[-1]
        others = (last["pot"] - last["given"]) / max(observation["agents"] - 1, 1)
        return give(min(math.floor(self._slope * others + rng.random()), had))

    def punishment(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Punish who gave least, among equals the first."""
        given, agent = observation["given"], observation["agent"]
        least = min(range(len(given)), key=given.__getitem__)
        is_less = self._punishes and given[least] < given[agent] and observation["tokens"] >= observation["cost"]
        return json.dumps({"action": f"agent {least}"}) if is_less else NOBODY

    def parameters(self) -> dict[str, Any]:
        """Return the policy and how it answers."""
        return super().parameters() | {"slope": self._slope, "punishes": self._punishes}
