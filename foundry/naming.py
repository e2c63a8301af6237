"""What the classes that configurations build are called: now, and in sweeps that were recorded before they moved.

Run ids and keys of answers hang on the name that a class had first, so that moving it changes none of them.
"""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

NO_FORMAT = "none"
"""What a prompt as it is written is called among formats."""

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
"""The scripted policies by the module that holds them now: module and class of each at first."""
MOVED: Mapping[str, str] = {
    "foundry.models.ollama.OllamaModel": "foundry.models.ollama.model.OllamaModel",
    "foundry.models.openai.OpenAIModel": "foundry.models.openai.model.OpenAIModel",
    "foundry.models.replay.ReplayModel": "foundry.running.replayed.ReplayModel",
    "foundry.models.transformers_model.TransformersModel": "foundry.models.local.model.TransformersModel",
    "foundry.prompts.Prompt": "foundry.prompts.prompt.Prompt",
    "foundry.runner.JoblibRunner": "foundry.running.local.LocalRunner",
    "foundry.runner_dask.DaskRunner": "foundry.running.dask.DaskRunner",
    "foundry.worlds.grid.GridScenario": "foundry.worlds.grid.world.GridScenario",
    "foundry.worlds.usd.interpreter.JsonInterpreter": "foundry.worlds.camera.language.interpreter.JsonInterpreter",
    "foundry.worlds.usd.interpreter.LastSentenceInterpreter": (
        "foundry.worlds.camera.language.interpreter.LastSentenceInterpreter"
    ),
    "foundry.worlds.usd.interpreter.LatestInterpreter": "foundry.worlds.camera.language.interpreter.LatestInterpreter",
    "foundry.worlds.usd.world.UsdScenario": "foundry.worlds.camera.world.CameraScenario",
    **{
        f"foundry.models.scripted.{first}": f"foundry.models.scripted.{form}.{first.rpartition('.')[2]}"
        for form, policies in _POLICIES.items()
        for first in policies.split()
    },
}
"""The names under which sweeps recorded classes that have moved since, and where these are now."""
_FIRST = {now: first for first, now in MOVED.items()}


def present(target: Any) -> Any:
    """Return where the class of a recorded target is now; what is no target stays as it is."""
    return MOVED.get(target, target) if isinstance(target, str) else target


def with_first_names(value: Any) -> Any:
    """Return a configuration with every `_target_`, at any depth, by the name that identity hangs on."""
    if isinstance(value, Mapping):
        return {
            key: _FIRST.get(present(inner), inner) if key == "_target_" else with_first_names(inner)
            for key, inner in value.items()
        }
    return [with_first_names(inner) for inner in value] if isinstance(value, list | tuple) else value


def target_of(target: str) -> Any:
    """Return what a target names, where it is now.

    Raises:
        ImportError: its module is not there.
        AttributeError: its module has no such thing.
        ValueError: it is no name.
    """
    return pkgutil.resolve_name(present(target))


def format_of(prompt: Mapping[str, Any]) -> str:
    """Return what the format of a prompt's configuration is called: its space and draw, or `none`."""
    space = prompt.get("format")
    return NO_FORMAT if space is None else f"{space.get('name')}/{space.get('draw', '?')}"


class Subject(NamedTuple):
    """Who is asked in a probe: a model with a prompt and a seed of its sampling, where several were asked for."""

    model: str
    prompt: str
    sampling_seed: str

    @classmethod
    def of(cls, config: Mapping[str, Any]) -> Subject:
        """Return who is asked in a run with this configuration."""
        sampling = config["sampling_seed"]
        return cls(config["model"]["name"], config["prompt"]["name"], "" if sampling is None else str(sampling))


def names_of(subjects: Iterable[Subject]) -> dict[Subject, str]:
    """Return what to call each, sorted: all that not all share, the model always."""
    found = sorted(set(subjects))
    told = [place for place in range(len(Subject._fields)) if place == 0 or len({one[place] for one in found}) > 1]
    return {one: " / ".join(filter(None, (one[place] for place in told))) for one in found}


def in_room(package: str, form: str, name: str) -> Any:
    """Return what `package.<form>` says under a name; None where there is no such room, or it says nothing."""
    room = f"{package}.{form}"
    if importlib.util.find_spec(room) is None:
        return None
    return getattr(importlib.import_module(room), name, None)
