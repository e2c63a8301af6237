"""Policies for the naming game."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.base import ScriptedModel


class BestResponse(ScriptedModel):
    """Says the name that would have brought most in the meetings that it remembers; a draw where several would."""

    def say(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say what others said most, any name where nothing was said."""
        names = sorted(observation["names"])
        heard = Counter(met["other"] for met in observation["memory"])
        most = max(heard[name] for name in names)
        best = [name for name in names if heard[name] == most]
        return json.dumps({"action": best[int(rng.integers(len(best)))]}, ensure_ascii=False)


class FocalName(ScriptedModel):
    """Says the first name in the order of the alphabet, as all others do that play it: a convention from the start."""

    def say(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say it."""
        return json.dumps({"action": min(observation["names"])}, ensure_ascii=False)
