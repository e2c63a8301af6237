"""Who is asked in a run: from its configuration and its parts to an asker."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from foundry.episode import Asker
from foundry.expansion import calls_seed
from foundry.models.base import Model, ModelInfo, RunContext
from foundry.prompts.prompt import Prompt
from foundry.worlds.base import Scenario


def in_run(model: Model, config: Mapping[str, Any], scenario: Scenario, info: ModelInfo) -> Model:
    """Return the model as it answers in the run of this configuration.

    Raises:
        InputError: it does not fit this run.
    """
    seed = config["seed"]
    return model.in_run(RunContext(seed, calls_seed(config), scenario.personas(seed), info))


def asker_of(config: Mapping[str, Any], scenario: Scenario, prompt: Prompt, model: Model, info: ModelInfo) -> Asker:
    """Return what puts the questions of a run.

    Args:
        config: the run's effective configuration.
        scenario: its world.
        prompt: its prompt variant.
        model: its model, wrapped.
        info: what is known of the model.

    Raises:
        InputError: the model does not fit this run.
    """
    placed = in_run(model, config, scenario, info)
    return Asker.create(placed, prompt, digest=info.digest, seed=calls_seed(config))
