"""Who answers in the checks: a policy that can act in a world and costs nothing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from foundry.composing.baselines import Stage
from foundry.running.build import build
from foundry.worlds.base import Scenario

_WALKERS: tuple[Mapping[str, Any], ...] = (
    {"_target_": "foundry.models.scripted.random.Random", "name": "scripted/random"},
    {"_target_": "foundry.models.scripted.wander.Wander", "name": "scripted/wander"},
)


def policy_for(scenario: Scenario, chosen: Mapping[str, Any], seed: int) -> Mapping[str, Any] | None:
    """Return the configuration of the chosen model if it can act here and costs nothing, else of a shipped policy.

    Args:
        scenario: the world.
        chosen: configuration of the model that was chosen with it.
        seed: of the episode that is played.
    """
    stage = Stage(scenario, seed)
    return next((one for one in (chosen, *_WALKERS) if stage.suits(build(one))), None)
