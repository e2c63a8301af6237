"""The policy whose replies are hard to read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.base import ScriptedModel


class Mumbler(ScriptedModel):
    """Says one of its sentences at random: readable ones in odd words, and unreadable ones."""

    def __init__(self, name: str, sentences: Sequence[str]) -> None:
        super().__init__(name)
        self._sentences = tuple(sentences)

    def parameters(self) -> dict[str, Any]:
        """Return the policy and its sentences."""
        return {**super().parameters(), "sentences": list(self._sentences)}

    def move(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Return one of the sentences."""
        return self._sentences[int(rng.integers(len(self._sentences)))]
