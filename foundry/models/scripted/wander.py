"""The policy that walks about in a 3D world."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.base import ScriptedModel
from foundry.models.scripted.spoken import forward, turn


class Wander(ScriptedModel):
    """Turns by a random angle or walks a random distance, each half of the time, whatever it sees."""

    def __init__(self, name: str, max_turn_deg: float = 90.0, max_distance_m: float = 2.0) -> None:
        super().__init__(name)
        self._max_turn_deg = max_turn_deg
        self._max_distance_m = max_distance_m

    def parameters(self) -> dict[str, Any]:
        """Return the policy and its ranges."""
        ranges = {"max_turn_deg": self._max_turn_deg, "max_distance_m": self._max_distance_m}
        return {**super().parameters(), **ranges}

    def move(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Return the next movement."""
        if rng.random() < 0.5:
            return f"Let me look elsewhere. {turn(float(rng.uniform(-1, 1)) * self._max_turn_deg)}"
        return f"Let me go on. {forward(float(rng.uniform(0.1, 1)) * self._max_distance_m)}"
