"""Checks everything that can be wrong with a sweep, once, before it starts."""

import asyncio
import json
import sys
import traceback
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from foundry.declared import Declared
from foundry.errors import FoundryError, InputError, NotInstalledError
from foundry.expansion import Condition, Sweep, settings_key
from foundry.models.base import Model, ModelInfo
from foundry.prompts.prompt import Prompt
from foundry.records import Outcome
from foundry.running.build import build, in_run
from foundry.storing.store import SweepFolder
from foundry.texts import one_line
from foundry.worlds.base import Answer, Question, Scenario

_EXAMPLES = {"string": "", "integer": 0, "number": 0, "boolean": False}
MAX_STEPS = 4
"""Maximum number of steps that are played to find a first question of every kind."""


def check_schemas(model: Mapping[str, Any], scenario: Scenario, questions: Sequence[Question]) -> None:
    """Raise an error if the world can read some, but not all, of the choices that a model's schema allows."""
    if type(scenario).read is Scenario.read:
        return
    held = [(schemas[asked.kind], asked) for schemas in _schemas(model) for asked in questions if asked.kind in schemas]
    for schema, question in held:
        for name, choices in _choices(schema):
            read = [choice for choice in choices if _is_read({**_example(schema), name: choice}, scenario, question)]
            if read and len(read) < len(choices):
                others = ", ".join(str(choice) for choice in choices if choice not in read)
                raise InputError(
                    f"The schema for '{question.kind}' lets models choose {others}. The world '{scenario.name}' "
                    "does not accept these choices with its present settings. Restrict the schema with "
                    f"schema.{question.kind}.properties.{name}.enum=[{','.join(map(str, read))}], or use no schema "
                    "with model.format=null."
                )


def _schemas(model: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    if model.get("format") == "schema":
        yield model.get("schemas") or {}
    for member in model.values():
        if isinstance(member, Mapping):
            yield from _schemas(member)


def _choices(schema: Mapping[str, Any]) -> Iterator[tuple[str, Sequence[Any]]]:
    for name, described in schema.get("properties", {}).items():
        if described.get("enum"):
            yield name, described["enum"]


def _example(schema: Mapping[str, Any]) -> dict[str, Any]:
    """Return a reply that fits the schema: each property has its first choice or its smallest value."""
    return {
        name: described["enum"][0]
        if described.get("enum")
        else described.get("minimum", _EXAMPLES.get(str(described.get("type"))))
        for name, described in schema.get("properties", {}).items()
    }


def _is_read(reply: Mapping[str, Any], scenario: Scenario, question: Question) -> bool:
    return scenario.read(question, Answer(json.dumps(reply))).outcome is not Outcome.UNREADABLE


@dataclass(frozen=True)
class _Opened:
    scenario: Scenario
    questions: tuple[Question, ...]


def check(sweep: Sweep) -> dict[str, ModelInfo]:
    """Build every part of the sweep, render every prompt once, and ask the servers about the models.

    Returns:
        The facts about each model, by `settings_key` of its configuration.
    """
    worlds: dict[str, _Opened] = {}
    models: dict[str, Model] = {}
    seeing: dict[str, str] = {}
    for condition in sweep.conditions:
        key = settings_key(condition.config["model"])
        model = models.setdefault(key, build(condition.config["model"]))
        parts = _parts_key(condition, model)
        if parts not in worlds:
            worlds[parts] = _check_condition(condition, model)
        _check_answers(model, worlds[parts].questions)
        check_schemas(condition.config["model"], worlds[parts].scenario, worlds[parts].questions)
        if worlds[parts].scenario.shows_images and model.costs:
            seeing[key] = worlds[parts].scenario.name
    infos = asyncio.run(_inspect(models))
    for condition in sweep.conditions:
        _check_in_runs(condition, models, infos, worlds)
    for key, world in seeing.items():
        check_sight(infos[key], world)
    return infos


def _parts_key(condition: Condition, model: Model) -> str:
    return settings_key({name: condition.config[name] for name in ("world", "prompt")}) + str(model.kinds)


def _check_in_runs(
    condition: Condition, models: Mapping[str, Model], infos: Mapping[str, ModelInfo], worlds: Mapping[str, _Opened]
) -> None:
    """Check that a population can answer in every run. Other models do not depend on the run, so they need no check."""
    key = settings_key(condition.config["model"])
    model, scenario = models[key], worlds[_parts_key(condition, models[key])].scenario
    for seed in condition.seeds:
        if in_run(model, {**condition.config, "seed": seed}, scenario, infos[key]) is model:
            return


def check_sight(info: ModelInfo, world: str) -> None:
    """Raise an error if a model cannot see the images of a world."""
    if "vision" in info.undeclared:
        raise InputError(
            f"World '{world}' shows images, and the server of '{info.name}' does not say whether the model sees. "
            "Use model.vision=true if it does."
        )
    if "vision" not in info.capabilities:
        raise InputError(
            f"Model '{info.name}' cannot see images, which world '{world}' shows. "
            "Choose one with the capability 'vision'; foundry doctor lists them."
        )


def scenario_of(config: Mapping[str, Any]) -> Scenario:
    """Build the world of a run from its configuration."""
    scenario: Scenario = build(config["world"])
    return scenario


def prompt_of(config: Mapping[str, Any]) -> Prompt:
    """Build the prompt of a run from its configuration."""
    prompt: Prompt = build(config["prompt"])
    return prompt


def worlds_left_out(configs: Sequence[Mapping[str, Any]]) -> tuple[frozenset[str], str]:
    """Return the names of worlds that need a missing package, and a sentence about them ("" if there are none)."""
    missing: dict[str, NotInstalledError] = {}
    for config in {settings_key(config["world"]): config for config in configs}.values():
        try:
            scenario_of(config)
        except NotInstalledError as error:
            missing[config["world"]["name"]] = error
        except InputError:  # reported when the sweep is checked
            continue
    if missing and missing.keys() == {config["world"]["name"] for config in configs}:
        raise next(iter(missing.values()))
    hints = dict.fromkeys(error.install for error in missing.values())
    line = f"Left out, since a package is missing: {', '.join(missing)}. {' '.join(hints)}" if missing else ""
    return frozenset(missing), line


def notes_of(sweep: Sweep) -> list[str]:
    """Return the notes of a sweep's worlds, one line each."""
    return list(dict.fromkeys(note for config in _worlds(sweep).values() for note in scenario_of(config).notes()))


def missing_arms(sweep: Sweep) -> list[str]:
    """Return a line for each world whose measures have an exact null, if the sweep lacks the runs for this null."""
    worlds = _worlds(sweep)
    lines = []
    for config in worlds.values():
        scenario = scenario_of(config)
        arm = scenario.null_arm()
        if arm and settings_key({**config["world"], **arm}) not in worlds:
            added = " ".join(f"+world.{key}={str(value).lower()}" for key, value in arm.items())
            lines.append(
                f"world '{scenario.name}': {added} with the same seeds adds runs in which no agent is told of the "
                "fires. Such runs give the exact null of the world's measures. Without such runs, the null "
                "assumes agents that draw each step independently"
            )
    return list(dict.fromkeys(lines))


def _worlds(sweep: Sweep) -> dict[str, Mapping[str, Any]]:
    return {settings_key(condition.config["world"]): condition.config for condition in sweep.conditions}


def declare(sweep: Sweep, here: Sweep | None = None) -> Sweep:
    """Return the sweep with the forms, actions and record files that its worlds declare.

    `here` is the same sweep, with paths of this machine.
    """
    declared: dict[str, Declared] = {}
    known: list[Condition] = []
    for condition, placed in zip(sweep.conditions, (here or sweep).conditions, strict=True):
        key = settings_key(placed.config["world"])
        if key not in declared:
            declared[key] = _declared(scenario_of(placed.config))
        known.append(replace(condition, declared=declared[key]))
    return replace(sweep, conditions=tuple(known))


def check_begun(there: SweepFolder, sweep: Sweep) -> None:
    """Raise an error if the worlds of a sweep have changed since its recorded runs began."""
    here = there.with_scenes(sweep).conditions
    worlds = {
        settings_key(condition.config["world"]): placed
        for condition, placed in zip(sweep.conditions, here, strict=True)
    }
    keys = [settings_key(condition.config["world"]) for condition in there.sweep.conditions]
    for run in there.runs():
        key = keys[run.run.condition]
        if key in worlds and "episode" in run.declared.streams and run.ended and (episode := run.episode_bytes()):
            scenario_of(worlds.pop(key).config).check_begun(episode)


def _declared(scenario: Scenario) -> Declared:
    try:
        return scenario.declared()
    except AttributeError as error:
        raise InputError(
            f"World '{scenario.name}' does not declare its records ({error}). Give its Scenario a `form`, such as "
            "'rounds', and the classes of its `records`."
        ) from error


def _check_answers(model: Model, questions: Sequence[Question]) -> None:
    """Raise an error if a model, or a member of a population, cannot answer a world's questions."""

    def checked(member: Model) -> Model:
        if isinstance(
            getattr(member, "remote", None), bool
        ):  # else no answer would be cached, and all would cost again
            raise InputError(
                f"Model '{member.name}' has an attribute `remote`, which is called `costs` now. Rename it."
            )
        for question in questions:
            member.check(question)
        return member

    model.wrapped(checked)


def _check_condition(condition: Condition, model: Model) -> _Opened:
    scenario, prompt = scenario_of(condition.config), prompt_of(condition.config)
    missing = [kind for kind in scenario.kinds if model.kinds is not None and kind not in model.kinds]
    if missing:
        raise InputError(
            f"Model '{model.name}' cannot act in world '{scenario.name}': it answers "
            f"{', '.join(model.kinds or ())}, but the world also asks {', '.join(missing)}."
        )
    questions = tuple(first_questions(scenario, condition.seeds[0]))
    for question in questions:
        prompt.render(question)
    return _Opened(scenario, questions)


def first_questions(scenario: Scenario, seed: int) -> Iterator[Question]:
    """Yield the first question of every kind, from an episode in which all answers are empty.

    Raises:
        InputError: the code of an own world raises another error; the message names the line in this code.
    """
    try:
        yield from _first_questions(scenario, seed)
    except Exception as error:
        file = getattr(sys.modules[type(scenario).__module__], "__file__", None)
        frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == file]
        if isinstance(error, FoundryError) or not frames or type(scenario).__module__.startswith("foundry."):
            raise
        cause = f"{type(error).__name__}: {one_line(error)} ({file}, line {frames[-1].lineno})"
        raise InputError(
            f"World '{scenario.name}' cannot be played with empty replies: {cause}. Correct the code of the world."
        ) from error


def _first_questions(scenario: Scenario, seed: int) -> Iterator[Question]:
    world = scenario.start(seed)
    seen: set[str] = set()
    while not world.finished and world.step < MAX_STEPS and len(seen) < len(scenario.kinds):
        questions = world.pending()
        for question in questions:
            if question.kind not in seen:
                seen.add(question.kind)
                yield question
        world.advance([Answer("") for _ in questions])


async def _inspect(models: Mapping[str, Model]) -> dict[str, ModelInfo]:
    try:
        return {key: await model.inspect() for key, model in models.items()}
    finally:
        for model in models.values():
            await model.close()
