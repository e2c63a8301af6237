"""The legal-move walker, the baseline for every movement."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.errors import InputError
from foundry.models.scripted.base import ScriptedModel
from foundry.models.scripted.grid import STAY, act, any_of, legal_moves, say


class Random(ScriptedModel):
    """Draws among the legal actions, `stay` included, and says nothing."""

    def __init__(self, name: str, stay_probability: float | None = None) -> None:
        """Set the odds.

        Args:
            name: name of the model.
            stay_probability: probability to stay, the legal directions sharing the rest; None makes all legal
                actions equally likely.
        """
        super().__init__(name)
        if stay_probability is not None and not 0 <= stay_probability <= 1:
            raise InputError(f"model.stay_probability is {stay_probability}. Give null, or a number from 0 to 1.")
        self.stay_probability = stay_probability

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say nothing."""
        return say(None, reasoning="I keep to myself.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Draw a legal action."""
        choices = list(legal_moves(observation))
        if self.stay_probability is not None:
            stays = rng.random() < self.stay_probability
            choices = [STAY] if stays else [choice for choice in choices if choice != STAY]
        return act(any_of(choices, rng), reasoning="A draw among the legal actions.")

    def parameters(self) -> dict[str, Any]:
        """Return the class and the odds."""
        return super().parameters() | {"stay_probability": self.stay_probability}
