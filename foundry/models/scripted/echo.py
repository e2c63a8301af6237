"""The policy that repeats what it hears."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.base import ScriptedModel
from foundry.models.scripted.grid import act, any_of, legal_moves, say


class Echo(ScriptedModel):
    """Repeats the last message it heard, or states its own number, and walks at random."""

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Repeat the last message."""
        received = observation["received"]
        text = received[-1]["text"] if received else f"I am Agent {observation['agent']}."
        return say(text, reasoning="I repeat what I hear.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Draw a legal action."""
        return act(any_of(list(legal_moves(observation)), rng), reasoning="A draw among the legal actions.")
