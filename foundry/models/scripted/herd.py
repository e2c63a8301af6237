"""The policy that joins others."""

from __future__ import annotations

from collections.abc import Mapping
from statistics import fmean
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.base import ScriptedModel
from foundry.models.scripted.grid import act, any_of, legal_moves, say, towards


class Herd(ScriptedModel):
    """Goes to the centroid of its neighbours, walks at random without any, and counts them aloud."""

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say how many are near."""
        near = len(observation["neighbours"])
        text = f"I am with {near} others. Let us stay together." if near else None
        return say(text, reasoning="I speak when somebody is near.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Step towards the neighbours, or at random."""
        neighbours = observation["neighbours"]
        if not neighbours:
            return act(any_of(list(legal_moves(observation)), rng), reasoning="I look for others.")
        x, y = fmean(other["x"] for other in neighbours), fmean(other["y"] for other in neighbours)
        return act(towards(observation, x, y, rng), reasoning="I join the others.")
