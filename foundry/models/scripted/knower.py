"""The policy that is told the answers: the upper bound of what can be asked of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.spin import Spin


class Knower(Spin):
    """Gives the right answer to every question about a walk, which no model is shown; on its own it looks around."""

    def nearer(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say which thing is nearer."""
        return _told(observation)

    def side(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say on which side a thing is."""
        return _told(observation)

    def count(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say how many things were to be seen."""
        return _told(observation)

    def order(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say in which order things came into view."""
        return _told(observation)

    def distance(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say how far a thing is."""
        return _told(observation)


def _told(observation: Mapping[str, Any]) -> str:
    answer: str = observation["answer"]
    return answer
