"""Makes the sweep of baselines: scripted policies that play the models' worlds, for comparison with the models."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from foundry import own_code, paths
from foundry.composing.names import check_own_names, with_public_names
from foundry.composing.preflight import first_questions, scenario_of
from foundry.errors import InputError, not_found
from foundry.expansion import Condition, Sweep, expand, settings_key
from foundry.models.base import Model
from foundry.running.build import build
from foundry.storing.plain import load_plain
from foundry.worlds.base import Question, Scenario

NULLS = ("scripted/wander", "scripted/random")
"""Policies that ignore their observations: a world gets the first as baseline that can answer its questions."""
BOUNDS = ("scripted/stay", "scripted/oracle")
"""The policy that does nothing, and the oracle: baselines of every world whose questions they can answer."""
_NAME = re.compile(r"[\w-]+(?:/[\w-]+)*")


def baselines_of(sweep: Sweep, known_policies: Callable[[str], Sequence[str]]) -> Sweep:
    """Return a sweep in which baselines play the same worlds, with the same seeds, as in the given sweep.

    Scripted policies read no prompt, so each world gets only its first prompt of the sweep. A policy that the sweep
    itself compares is left out, since it already has runs. A world may name its baselines (`baselines`). Otherwise they
    are the first of `NULLS` and all of `BOUNDS` that can act in it. The policies with which a world's score is compared
    are always included.
    """
    check_own_names(own_code.own_folders())
    worlds: dict[str, list[Condition]] = {}
    for condition in sweep.conditions:
        worlds.setdefault(settings_key(condition.config["world"]), []).append(condition)
    compared = {condition.config["model"]["name"] for condition in sweep.conditions}
    conditions = [
        condition for conditions in worlds.values() for condition in _conditions(conditions, compared, known_policies)
    ]
    return expand(("baselines of", *sweep.asked), conditions)


@dataclass(frozen=True)
class Stage:
    """Tests whether a policy can be a baseline of a world, with the questions of one seed."""

    scenario: Scenario
    seed: int

    @cached_property
    def questions(self) -> Sequence[Question]:
        """The first question of every kind."""
        return tuple(first_questions(self.scenario, self.seed))

    def check(self, model: Model) -> None:
        """Raise an error if a policy cannot answer the questions of the world."""
        if model.costs:
            raise InputError(
                f"'{model.name}' cannot be a baseline, because its calls cost something. Name a scripted policy."
            )
        missing = [kind for kind in self.scenario.kinds if model.kinds is not None and kind not in model.kinds]
        if missing:
            raise InputError(
                f"'{model.name}' cannot be a baseline of world '{self.scenario.name}': "
                f"it does not answer '{missing[0]}'."
            )
        for question in self.questions:
            model.check(question)

    def suits(self, model: Model) -> bool:
        """Return whether a policy can answer the questions of the world."""
        try:
            self.check(model)
        except InputError:
            return False
        return True


def _conditions(
    conditions: list[Condition], compared: set[str], known_policies: Callable[[str], Sequence[str]]
) -> Iterator[Condition]:
    first = conditions[0]
    seeds = tuple(sorted({seed for condition in conditions for seed in condition.seeds}))
    stage = Stage(scenario_of(first.config), seeds[0])
    factors = {key: value for key, value in first.factors.items() if _is_of_world(key)}
    chosen = first.config.get("baselines")
    models = _suited(stage) if chosen is None else _declared(chosen, stage)
    names = {model["name"] for model in models}
    models += _declared([name for name in known_policies(stage.scenario.name) if name not in names], stage)
    for model in models:
        if model["name"] not in compared:
            own = {key: value for key, value in first.config.items() if key != "fork"}  # from the first step on
            config = {**own, "model": model, "sampling_seed": None}
            yield Condition({**factors, "model": model["name"]}, config, seeds, stage.scenario.declared())


def _suited(stage: Stage) -> list[dict[str, Any]]:
    nulls, bounds = ([model for model in map(_model, names) if stage.suits(build(model))] for names in (NULLS, BOUNDS))
    return [*nulls[:1], *bounds]


def _declared(names: Sequence[str], stage: Stage) -> list[dict[str, Any]]:
    models = [_model(name) for name in names]
    for model in models:
        stage.check(build(model))
    return models


def _model(name: str) -> dict[str, Any]:
    folders = [folder / "model" for folder in (*own_code.own_folders(), paths.conf_dir())]
    places = [folder / f"{name}.yaml" for folder in folders] if _NAME.fullmatch(name) else []
    file = next((place for place in places if place.is_file()), None)
    if file is None:
        known = [file.relative_to(folder).with_suffix("") for folder in folders for file in folder.rglob("*.yaml")]
        hint = "Your own policies are in the folder model/ of --config-dir."
        raise not_found("Baseline", name, [name.as_posix() for name in known], hint)
    text = file.read_text(encoding="utf-8")
    config = load_plain(text, file)
    if not isinstance(config, dict) or not isinstance(config.get("name"), str) or "defaults" in config or "${" in text:
        raise InputError(
            f"Baseline '{name}' cannot be used: {file} must have a `name`, but no `defaults` and no references "
            "such as ${seed}."
        )
    model: dict[str, Any] = with_public_names(config)
    return model


def _is_of_world(key: str) -> bool:
    return key.lstrip("+").split(".")[0] not in ("model", "prompt", "sampling_seed", "seed")
