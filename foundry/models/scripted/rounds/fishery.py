"""Policies for the fishery, silent in its conversations."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.base import ScriptedModel


class GreedyCatch(ScriptedModel):
    """Wants all that there is."""

    def catch(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Want the whole stock."""
        return json.dumps({"action": observation["stock"]})

    def talk(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say nothing."""
        return json.dumps({"message": None})


class SustainableCatch(GreedyCatch):
    """Takes as much as all may take so that the stock grows back."""

    def catch(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Want an equal share of half of the stock, in whole tons."""
        return json.dumps({"action": observation["stock"] // 2 // observation["agents"]})
