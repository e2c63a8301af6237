"""The policy that knows the best action: an upper bound where an environment tells its rules."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.errors import InputError
from foundry.models.scripted.base import ScriptedModel
from foundry.worlds.base import Question


class Planner(ScriptedModel):
    """Does what is best from where it is, with so many turns left; it reads what no model is shown: `best`."""

    def check(self, question: Question) -> None:
        """Refuse an environment that does not tell its rules.

        Raises:
            InputError: it does not.
        """
        if question.kind == "turn" and "best" not in question.told:
            raise InputError(f"Model '{self.name}' plans by a table of rules, which this environment has not.")

    def turn(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Return the best action."""
        return json.dumps({"action": observation["best"], "reasoning": "It is worth most in the mean."})
