"""Builds objects from configurations, with `_target_` as the only registry; and the asker of a run."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from foundry.episode import Asker
from foundry.errors import FoundryError, InputError
from foundry.expansion import calls_seed
from foundry.models.answers.answers import Answers
from foundry.models.answers.unconfirmed import Unconfirmed
from foundry.models.base import Model, ModelInfo, RunContext
from foundry.models.serving import InFlight, serving_of
from foundry.models.wrappers.cached import CachedModel, WarmedModel
from foundry.models.wrappers.canaries import watch_of
from foundry.models.wrappers.confirmed import ConfirmedModel
from foundry.models.wrappers.limited import Limit, LimitedModel
from foundry.models.wrappers.retried import RetriedModel
from foundry.naming import target_of
from foundry.prompts.prompt import Prompt
from foundry.texts import one_line
from foundry.worlds.base import Scenario


def build(config: Mapping[str, Any]) -> Any:
    """Build the object that a configuration's `_target_` names; the other keys are the arguments.

    Parts that have a `_target_` too are built first. Hydra's `instantiate` would resolve every `${...}` in a text
    again, even in a prompt, or in a configuration that someone else recorded.
    """
    if "_target_" not in config:
        raise InputError(f"The configuration of '{config.get('name', '?')}' has no _target_ to build.")
    try:
        return _built(config)
    except FoundryError:
        raise
    except ModuleNotFoundError as error:
        name = config.get("name", config["_target_"])
        raise InputError(
            f"'{name}' cannot be built: {error}. If this is your own code, name its folder with --config-dir."
        ) from error
    except Exception as error:
        name, target = config.get("name", config["_target_"]), config["_target_"]
        raise InputError(f"'{name}' ({target}) cannot be built from its settings: {one_line(error)}") from error


def _built(value: Any) -> Any:
    if isinstance(value, Mapping):
        parts = {key: _built(inner) for key, inner in value.items() if key != "_target_"}
        return target_of(value["_target_"])(**parts) if "_target_" in value else parts
    return [_built(inner) for inner in value] if isinstance(value, list | tuple) else value


def model_stack(
    model: Model,
    answers: Callable[[], Answers],
    info: ModelInfo | None = None,
    limit: Callable[[InFlight], Limit] = Limit,
) -> Model:
    """Wrap a model that costs something, or each of its members."""
    known = iter(() if info is None else each_info(info))
    return model.wrapped(lambda one: _stacked(one, answers, next(known, None), limit))


def members_of(model: Model) -> list[Model]:
    """Return the model, or the models to which it passes requests."""
    members: list[Model] = []

    def noted(one: Model) -> Model:
        members.append(one)
        return one

    model.wrapped(noted)
    return members


def served_by_others(model: Model) -> list[Model]:
    """Return the models that other processes serve."""
    return [member for member in members_of(model) if member.costs and not member.in_process]


def each_info(info: ModelInfo) -> Iterator[ModelInfo]:
    """Yield the facts of a model, or of its members in the order of their wrappers."""
    if not info.members:
        yield info
    for member in info.members:
        yield from each_info(member)


def _stacked(
    model: Model, answers: Callable[[], Answers], info: ModelInfo | None, limit: Callable[[InFlight], Limit]
) -> Model:
    """Wrap a model that costs something: cache, then one warm-up, then limit, then retry, then its weights."""
    if not model.costs:
        return model
    serving = serving_of(model)
    kept = answers()
    known = info if model.replaceable and info is not None and info.digest is not None else None
    unconfirmed = Unconfirmed(kept, known, model.weights_of)
    confirmed = model if known is None else ConfirmedModel(model, unconfirmed, known, watch_of(model, known, kept))
    bounds = serving.in_flight if info is None or info.slots is None else serving.in_flight.from_slots(info.slots)
    in_flight = Limit(bounds) if model.in_process else limit(bounds)
    retried = RetriedModel(confirmed, serving.retry, noted=in_flight.note_failure)
    return CachedModel(WarmedModel(LimitedModel(retried, in_flight)), unconfirmed)


def in_run(model: Model, config: Mapping[str, Any], scenario: Scenario, info: ModelInfo) -> Model:
    """Return the model in the form that answers in a run, given the run's configuration."""
    seed = config["seed"]
    return model.in_run(RunContext(seed, calls_seed(config), scenario.personas(seed), info))


def asker_of(config: Mapping[str, Any], scenario: Scenario, prompt: Prompt, model: Model, info: ModelInfo) -> Asker:
    """Return the asker of a run, which puts its questions to the model."""
    placed = in_run(model, config, scenario, info)
    return Asker.create(placed, prompt, digest=info.digest, seed=calls_seed(config))
