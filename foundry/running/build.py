"""Builds an object of the class that `_target_` names in a configuration, and wraps the models of a run."""

import inspect
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from foundry.episode import Asker
from foundry.errors import FoundryError, InputError, not_found
from foundry.expansion import calls_seed, leaves
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
    """Build an object of the class that `_target_` names; all other keys are its arguments.

    Parts of the configuration that have a `_target_` are built first. Hydra's `instantiate` is not used, because it
    would resolve `${...}` in texts again, also in prompts and in configurations that someone else recorded.
    """
    if "_target_" not in config:
        raise InputError(f"The configuration of '{config.get('name', '?')}' has no _target_ to build.")
    target = config["_target_"]
    name = config.get("name", target)
    try:
        return _built(config)
    except FoundryError:
        raise
    except ModuleNotFoundError as error:
        raise InputError(
            f"'{name}' cannot be built: {error}. If this is your own code, name its folder with --config-dir."
        ) from error
    except Exception as error:
        raise InputError(f"'{name}' ({target}) cannot be built from its settings: {one_line(error)}") from error


def _built(value: Any) -> Any:
    if isinstance(value, Mapping):
        parts = {key: _built(inner) for key, inner in value.items() if key != "_target_"}
        return _made(value, parts) if "_target_" in value else parts
    return [_built(inner) for inner in value] if isinstance(value, list | tuple) else value


def _made(config: Mapping[str, Any], parts: Mapping[str, Any]) -> Any:
    """Build an object from its built parts; an error names the first setting that the class does not take."""
    made = target_of(config["_target_"])
    try:
        return made(**parts)
    except TypeError as error:
        known = _settings_of(made)
        unknown = [name for name in parts if known is not None and name not in known]
        if known is None or not unknown:
            raise
        deeper = [path for path, _ in leaves(config) if path.endswith(f".{unknown[0]}")]
        where = f"'{config['name']}' ({config['_target_']})" if "name" in config else config["_target_"]
        hint = "Correct the setting, or leave it out."
        raise not_found(f"{where}: setting", unknown[0], [*known, *deeper], hint) from error


def _settings_of(made: Any) -> list[str] | None:
    """Return the names of the settings that a class or one of its bases takes; None if it takes any name."""
    bases = [base for base in getattr(made, "__mro__", ())[1:-1] if "__init__" in vars(base)]
    known: list[str] = []
    for part in (made, *bases):
        parameters = inspect.signature(part).parameters.values()
        known += [par.name for par in parameters if par.kind in (par.POSITIONAL_OR_KEYWORD, par.KEYWORD_ONLY)]
        if not any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters):
            return known
    return None


def model_stack(
    model: Model,
    answers: Callable[[], Answers],
    info: ModelInfo | None = None,
    limit: Callable[[InFlight], Limit] = Limit,
) -> Model:
    """Add a cache, limit and repetitions to a model whose calls cost something, or to each such member of a population.

    For each of them, `answers` opens the cache of answers, and `limit` makes the limit on calls in flight.
    """
    known = iter(() if info is None else each_info(info))
    return model.wrapped(lambda inner: _stacked(inner, answers, next(known, None), limit))


def members_of(model: Model) -> list[Model]:
    """Return the members of a population; for any other model, return a list with this model."""
    members: list[Model] = []

    def noted(model: Model) -> Model:
        members.append(model)
        return model

    model.wrapped(noted)
    return members


def served_by_others(model: Model) -> list[Model]:
    """Return the members of a model that run on a server, not in this process."""
    return [member for member in members_of(model) if member.costs and not member.in_process]


def each_info(info: ModelInfo) -> Iterator[ModelInfo]:
    """Yield the information about a model, or about each member of a population in order."""
    if not info.members:
        yield info
    for member in info.members:
        yield from each_info(member)


def _stacked(
    model: Model, answers: Callable[[], Answers], info: ModelInfo | None, limit: Callable[[InFlight], Limit]
) -> Model:
    """Add a cache, a warm-up, a limit on calls, repetitions and a check of the weights to a model whose calls cost."""
    if not model.costs:
        return model
    serving = serving_of(model)
    store = answers()
    known = info if model.replaceable and info is not None and info.digest is not None else None
    unconfirmed = Unconfirmed(store, known, model.weights_of)
    confirmed = model if known is None else ConfirmedModel(model, unconfirmed, known, watch_of(model, known, store))
    bounds = serving.in_flight if info is None or info.slots is None else serving.in_flight.from_slots(info.slots)
    in_flight = Limit(bounds) if model.in_process else limit(bounds)
    retried = RetriedModel(confirmed, serving.retry, noted=in_flight.note_failure)
    return CachedModel(WarmedModel(LimitedModel(retried, in_flight)), unconfirmed)


def in_run(model: Model, config: Mapping[str, Any], scenario: Scenario, info: ModelInfo) -> Model:
    """Return the model that answers in a run; a population, for example, then knows which agents its members play."""
    seed = config["seed"]
    return model.in_run(RunContext(seed, calls_seed(config), scenario.personas(seed), info))


def asker_of(config: Mapping[str, Any], scenario: Scenario, prompt: Prompt, model: Model, info: ModelInfo) -> Asker:
    """Return the asker of a run, which turns the world's questions into prompts and sends them to the model."""
    placed = in_run(model, config, scenario, info)
    return Asker.create(placed, prompt, digest=info.digest, seed=calls_seed(config))
