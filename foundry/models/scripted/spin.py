"""The policy that looks around on the spot."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.base import ScriptedModel
from foundry.models.scripted.spoken import turn


class Spin(ScriptedModel):
    """Turns left by the same angle at every decision."""

    def __init__(self, name: str, turn_deg: float = 45.0) -> None:
        super().__init__(name)
        self._turn_deg = turn_deg

    def parameters(self) -> dict[str, Any]:
        """Return the policy and its angle."""
        return {**super().parameters(), "turn_deg": self._turn_deg}

    def move(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Return the next movement."""
        return f"I look around. {turn(self._turn_deg)}"
