"""The policy part_name: replace its behaviour by one that you want to compare with models."""

from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry import ScriptedModel
from foundry.worlds.grid.grid_policies import act, legal_moves, say


class PartName(ScriptedModel):
    """Walks to the right until the edge, and says nothing. The method `action` answers questions of kind `action`."""

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say nothing."""
        return say(None, reasoning="I keep to myself.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Go right if possible, else stay. A policy with random choices draws them only from `rng`."""
        choice = "right" if "right" in legal_moves(observation) else "stay"
        return act(choice, reasoning="I go to the right.")
