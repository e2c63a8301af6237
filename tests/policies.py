"""Scripted models that misbehave, for tests; configured through `_target_` like anybody's own parts."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.stay import Stay


class Deadly(Stay):
    """Kills its own process when the persona of an agent is `doomed`."""

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        if observation["persona"]["fate"] == "doomed":
            os._exit(9)
        return super().action(observation, rng)


class Faulty(Stay):
    """Has a bug that shows when the persona of an agent is `doomed`."""

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        if observation["persona"]["fate"] == "doomed":
            raise ZeroDivisionError("a bug")
        return super().action(observation, rng)
