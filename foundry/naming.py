"""Finds the current class for an import path in a recorded sweep, and names the subjects of probes.

Run ids and keys of cached answers use the oldest import path of a class, so they stay valid if the class moves.
"""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

NO_FORMAT = "none"
"""The name of the format that leaves a prompt unchanged."""

_POLICIES = {
    "any": "first.First random.Random stay.Stay",
    "grid": (
        "avoid.Avoid echo.Echo evacuating.FollowLeader evacuating.ShortestPath herd.Herd seek.Seek surviving.Fighter "
        "surviving.Forager surviving.Sharer"
    ),
    "camera": "knower.Knower mumbler.Mumbler oracle.Oracle spin.Spin wander.Wander",
    "rounds": (
        "rounds.bar.Inductive rounds.bar.Mixing rounds.bar.Tossing rounds.fishery.GreedyCatch "
        "rounds.fishery.SustainableCatch rounds.naming.BestResponse rounds.naming.FocalName rounds.planner.Planner "
        "rounds.public_goods.Conditional rounds.public_goods.FreeRider"
    ),
}
"""The scripted policies of each form, by their first module and their class."""
POLICY_MODULES = {form: f"foundry.worlds.{form}.{form}_policies" for form in _POLICIES}
"""The module with the scripted policies of each form."""
MOVED: Mapping[str, str] = {
    "foundry.models.ollama.OllamaModel": "foundry.models.ollama.ollama_model.OllamaModel",
    "foundry.models.openai.OpenAIModel": "foundry.models.openai.openai_model.OpenAIModel",
    "foundry.models.replay.ReplayModel": "foundry.running.replayed.ReplayModel",
    "foundry.models.transformers_model.TransformersModel": "foundry.models.local.local_model.TransformersModel",
    "foundry.prompts.Prompt": "foundry.prompts.prompt.Prompt",
    "foundry.runner.JoblibRunner": "foundry.running.local.LocalRunner",
    "foundry.runner_dask.DaskRunner": "foundry.running.dask.DaskRunner",
    "foundry.worlds.grid.GridScenario": "foundry.worlds.grid.grid_world.GridScenario",
    "foundry.worlds.usd.interpreter.JsonInterpreter": "foundry.worlds.camera.language.interpreter.JsonInterpreter",
    "foundry.worlds.usd.interpreter.LastSentenceInterpreter": (
        "foundry.worlds.camera.language.interpreter.LastSentenceInterpreter"
    ),
    "foundry.worlds.usd.interpreter.LatestInterpreter": "foundry.worlds.camera.language.interpreter.LatestInterpreter",
    "foundry.worlds.usd.world.UsdScenario": "foundry.worlds.camera.camera_world.CameraScenario",
    **{
        f"foundry.models.scripted.{first}": f"{POLICY_MODULES[form]}.{first.rpartition('.')[2]}"
        for form, policies in _POLICIES.items()
        for first in policies.split()
    },
}
"""The current path of each class that moved, by the path that older sweeps record."""
_MODULES: Mapping[str, str] = {
    **{f"foundry.models.scripted.{form}": module for form, module in POLICY_MODULES.items()},
    **{
        f"foundry.models.{backend}.model": f"foundry.models.{backend}.{backend}_model"
        for backend in ("human", "local", "ollama", "openai")
    },
    **{f"foundry.worlds.{room}.world": f"foundry.worlds.{room}.{room}_world" for room in ("camera", "grid", "probe")},
    **{
        f"foundry.worlds.camera.{room}.world": f"foundry.worlds.camera.{room}_world"
        for room in ("following", "probing")
    },
}
"""The current path of each module that moved with all its classes, by the module's former path."""
_FIRST = {now: first for first, now in MOVED.items()}
_FIRST_MODULES = {now: first for first, now in _MODULES.items()}


def present(target: Any) -> Any:
    """Return the current import path for a class path from an old record; return anything else unchanged."""
    return _renamed(target, MOVED, _MODULES)


def _renamed(target: Any, classes: Mapping[str, str], modules: Mapping[str, str]) -> Any:
    if not isinstance(target, str):
        return target
    module, dot, name = target.rpartition(".")
    return classes.get(target) or f"{modules.get(module, module)}{dot}{name}"


def with_first_names(value: Any) -> Any:
    """Replace each `_target_` in a configuration by the first path that its class had."""
    if isinstance(value, Mapping):
        return {
            key: _renamed(present(inner), _FIRST, _FIRST_MODULES) if key == "_target_" else with_first_names(inner)
            for key, inner in value.items()
        }
    return [with_first_names(inner) for inner in value] if isinstance(value, list | tuple) else value


def target_of(target: str) -> Any:
    """Import the class or function that a `_target_` names, even if it has moved.

    Raises:
        ImportError: its module does not exist.
        AttributeError: its module lacks the object.
        ValueError: the target is not an import path.
    """
    return pkgutil.resolve_name(present(target))


def format_of(prompt: Mapping[str, Any]) -> str:
    """Return the name of a prompt's format, such as `spread/3`; return `none` if the prompt has no format."""
    space = prompt.get("format")
    return NO_FORMAT if space is None else f"{space.get('name')}/{space.get('draw', '?')}"


class Subject(NamedTuple):
    """A subject of a probe: a model with a prompt and a sampling seed."""

    model: str
    prompt: str
    sampling_seed: str

    @classmethod
    def of(cls, config: Mapping[str, Any]) -> Subject:
        """Return the subject of a run with this configuration."""
        sampling = config["sampling_seed"]
        return cls(config["model"]["name"], config["prompt"]["name"], "" if sampling is None else str(sampling))


def names_of(subjects: Iterable[Subject]) -> dict[Subject, str]:
    """Return a name for each subject: its model, with prompt or sampling seed if these differ between subjects."""
    distinct = sorted(set(subjects))
    places = [
        place
        for place in range(len(Subject._fields))
        if place == 0 or len({subject[place] for subject in distinct}) > 1
    ]
    return {subject: " / ".join(filter(None, (subject[place] for place in places))) for subject in distinct}


def in_room(module: str, name: str) -> Any:
    """Return an attribute of one of foundry's modules, or None if there is no such module or attribute."""
    parts = module.split(".")
    packages = (".".join(parts[: depth + 1]) for depth in range(1, len(parts)))
    if any(importlib.util.find_spec(package) is None for package in packages):
        return None
    return getattr(importlib.import_module(module), name, None)
