"""The policy that does nothing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.models.scripted import spoken
from foundry.models.scripted.base import ScriptedModel
from foundry.models.scripted.grid import STAY, act, say


class Stay(ScriptedModel):
    """Never moves and says nothing."""

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say nothing."""
        return say(None, reasoning="I keep to myself.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Stay."""
        return act(STAY, reasoning="I stay where I am.")

    def move(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Stay."""
        return f"I stay where I am. {spoken.STAY}"
