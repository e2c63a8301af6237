"""From configuration to objects: `_target_` is the only registry."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from foundry.errors import FoundryError, InputError
from foundry.models.answers import Answers
from foundry.models.base import Model
from foundry.models.cached import CachedModel
from foundry.models.limited import LimitedModel
from foundry.models.retried import RetriedModel
from foundry.models.serving import ServedModel
from foundry.models.warmed import WarmedModel


def build(config: Mapping[str, Any]) -> Any:
    """Build the object that a configuration's `_target_` names, its other keys being the arguments.

    Raises:
        InputError: there is no such target, or it does not take these settings.
    """
    from hydra.errors import HydraException
    from hydra.utils import instantiate

    if "_target_" not in config:
        raise InputError(f"The configuration of '{config.get('name', '?')}' has no _target_ to build.")
    try:
        return instantiate(dict(config), _convert_="all")
    except HydraException as error:
        if isinstance(error.__cause__, FoundryError):
            raise error.__cause__ from None
        cause = error.__cause__ or error
        name = config.get("name", config["_target_"])
        raise InputError(f"'{name}' cannot be built from its settings: {_one_line(cause)}") from error


def model_stack(model: Model, answers: Callable[[], Answers]) -> Model:
    """Wrap a model that costs something: cache, then one warm-up, then limit, then retry."""
    if not isinstance(model, ServedModel):
        return model
    retry, in_flight = model.server.retry, model.server.in_flight
    retried = RetriedModel(
        model,
        attempts=retry.attempts,
        unusable_attempts=retry.unusable_attempts,
        wait_initial_s=retry.wait_initial_s,
        wait_max_s=retry.wait_max_s,
    )
    limited = LimitedModel(retried, min=in_flight.min, max=in_flight.max, initial=in_flight.initial)
    return CachedModel(WarmedModel(limited), answers())


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())
