"""Every shipped world, prompt, policy, backend and signature holds what a user's own must hold."""

import importlib
from collections.abc import Collection
from dataclasses import replace
from functools import cache
from typing import Any

import pytest
import yaml

from episodes import ROOM
from foundry.composing.compose import compose
from foundry.composing.preflight import prompt_of
from foundry.conformance import edits, models
from foundry.conformance.checking import CHECKS, with_parts, world_case
from foundry.conformance.playing import Status, WorldCase, examine, failed, look
from foundry.conformance.signatures import case_with, run_type, shipped_signatures
from foundry.conformance.worlds import follows_its_seed
from foundry.paths import conf_dir, sweeps_dir
from foundry.running.build import build
from foundry.worlds.probe.editing import edits_of

SMALL_PICTURES = ("world.camera.width=64", "world.camera.height=48", "world.steps=2")
TINY = ("scene=kibo.usdz", "world.things.pixels=3", *SMALL_PICTURES)
SMALL = {
    "cafe_library": ("world.agents=5", "world.steps=3"),
    "cafe_library_drawn": ("world.agents=5", "world.steps=2"),
    "bar_arthur": ("world.agents=8", "world.steps=2"),
    "evacuation": ("world.agents=6", "world.steps=2"),
    "evacuation_corridor": ("world.agents=6", "world.steps=2"),
    "evacuation_floor": ("world.agents=6", "world.steps=2"),
    "follow": TINY,
    "kibo": SMALL_PICTURES,
    "map_probe": TINY,
    "usd": (
        f"scene={ROOM}",
        "task=Look",
        "world.targets=[{name: wall, prims: [/Room/North], radius: 1}]",
        *SMALL_PICTURES,
    ),
    "survival": ("world.agents=6", "world.steps=4", "world.half_size=3", "world.energy.start=40"),
}
SCENES = ("kibo", "kibo_paper", "office", "gallery", "follow", "map_probe")
ABSTRACT = ("usd",)
"""Worlds that others build on, and that are none without them."""


def names(group: str) -> list[str]:
    folder = conf_dir() / group
    return sorted(file.relative_to(folder).with_suffix("").as_posix() for file in folder.rglob("*.yaml"))


PLAIN = [name for name in names("world") if name not in {*SCENES, *ABSTRACT}]
ALWAYS = ("bar", "cafe_library", "cliff_walking", "naming")
"""A world of each kind, which every run of the tests tries; the slow tests try the others."""
WORLDS = (
    *(name if name in ALWAYS else pytest.param(name, marks=pytest.mark.slow) for name in PLAIN),
    "usd",
    *(pytest.param(name, marks=pytest.mark.exhaustive) for name in SCENES),
)
FIRST = ("cafe_library", "usd")
"""The worlds that policies and prompts which could do in several are tried in; the second one is a small room."""


@cache
def config(world: str, *overrides: str) -> Any:
    small = SMALL.get(world, ("world.steps=2",))
    composed = compose([f"world={world}", *small, *overrides])
    return composed.conditions[0].config


@cache
def case(world: str) -> WorldCase:
    return world_case(config(world), seed=3)


def plain(group: str, name: str) -> Any:
    """Return a configuration of which all stands in its one file."""
    return yaml.safe_load((conf_dir() / group / f"{name}.yaml").read_text(encoding="utf-8"))


def world_for(kinds: Collection[str] | None) -> str:
    """Return a world that asks these kinds of questions and no others."""
    order = dict.fromkeys((*FIRST, *PLAIN, "map_probe"))
    return next(name for name in order if kinds is None or set(case(name).scenario.kinds) <= set(kinds))


def test_the_sweep_of_all_worlds_names_every_one():
    params = yaml.safe_load((sweeps_dir() / "worlds.yaml").read_text(encoding="utf-8"))["hydra"]["sweeper"]["params"]
    assert sorted(params["world"].split(",")) == sorted({*names("world")} - {*ABSTRACT})


@pytest.mark.parametrize("world", WORLDS)
def test_a_world_holds_what_every_world_must_hold(world: str):
    assert failed(examine(f"world {world}", CHECKS["world"], case(world))) == []


@pytest.mark.parametrize("world", FIRST)
def test_another_seed_gives_another_episode(world: str):
    assert look(f"world {world}", follows_its_seed, case(world)).note == ""


PROMPTS = [
    name if name in {*ALWAYS, "japanese", "json", "paper"} else pytest.param(name, marks=pytest.mark.slow)
    for name in names("prompt")
]
"""Prompts of the worlds that are always tried, and three of the default one; the slow tests try the others."""


@pytest.mark.parametrize("name", PROMPTS)
def test_a_prompt_holds_what_every_prompt_must_hold(name: str):
    prompt, own = plain("prompt", name), name.removesuffix("_japanese")
    world = own if own in names("world") else world_for(prompt["templates"])
    config_of_both = {**config(world), "prompt": prompt}
    asked = replace(case(world), make_prompt=lambda: prompt_of(config_of_both), templates=prompt["templates"])
    vars(asked).update(usual=case(world).usual, silent=case(world).silent)  # policies read no prompt
    assert failed(examine(f"prompt {name}", CHECKS["prompt"], asked)) == []


@pytest.mark.parametrize("world", WORLDS)
def test_an_edit_holds_what_every_edit_must_hold_in_all_worlds_of_its_form(world: str):
    names = dict.fromkeys(edit.name for edit in edits_of(case(world).scenario.form))
    for edit in (edit for name in names for edit in with_parts(name, case(world))):
        assert failed(examine(f"edit {edit.name}", CHECKS["edit"], edits.EditCase(edit, case(world)))) == []


def test_every_shipped_edit_changes_something_in_some_world():
    tried = ("cafe_library", "survival", "bar", "public_goods_punishment", "naming", "usd")
    cases = [edits.EditCase(edit, case(world)) for world in tried for edit in edits_of(case(world).scenario.form)]
    changing = [case for case in cases if look("edit", edits.changes_something, case).status is Status.PASSED]
    assert {case.edit.name for case in cases} - {edit_case.edit.name for edit_case in changing} == {"no_messages"}, (
        "nobody speaks"
    )


SETTINGS = {"ollama": (), "openai": ("model.served=some", "model.server.base_url=http://127.0.0.1:1/v1")}
POLICIES = [
    name if name in {"scripted/oracle", "scripted/random"} else pytest.param(name, marks=pytest.mark.slow)
    for name in names("model")
    if name.startswith("scripted/")
]


@pytest.mark.parametrize("name", [*POLICIES, *SETTINGS])
def test_a_model_holds_what_every_model_must_hold(name: str):
    settings = plain("model", name)
    if name in SETTINGS:
        settings = config("cafe_library", f"model={name}", *SETTINGS[name])["model"]
    world = world_for(build(settings).kinds)
    assert failed(examine(f"model {name}", CHECKS["model"], models.ModelCase(build, settings, case(world)))) == []


@cache
def tried(world: str) -> Any:
    return case_with(config(world), case(world))


def shipped(form: str, world: str) -> list[tuple[str, str]]:
    return [(world, module) for _, module in shipped_signatures(form)]


@pytest.mark.parametrize(
    ("world", "module"),
    [
        *shipped("grid", "cafe_library"),
        *(pytest.param(*one, marks=pytest.mark.slow) for one in shipped("grid", "evacuation")),
        *(pytest.param(*one, marks=pytest.mark.slow) for one in shipped("grid", "survival")),
        *(pytest.param(*one, marks=pytest.mark.exhaustive) for one in shipped("camera", "follow")),
    ],
)
def test_a_signature_holds_what_every_signature_must_hold(world: str, module: str):
    assert failed(examine(module, CHECKS["signature"], tried(world)(importlib.import_module(module)))) == []


def is_about(module: Any, world: str) -> bool:
    """Tell whether a signature is about runs of a world."""
    case_of = tried(world)(module)
    return any(module.applies(run) for run in case_of.runs if isinstance(run, run_type(module)))


@pytest.mark.parametrize("name", [name for name, module in shipped_signatures("rounds") if ".rounds." in module])
def test_a_signature_of_some_games_holds_the_same_in_one_that_it_is_about(name: str):
    module = importlib.import_module(f"analysis.rounds.signatures.{name}")
    world = next(one for one in sorted(PLAIN, key=lambda one: not one.startswith(name)) if is_about(module, one))
    assert failed(examine(name, CHECKS["signature"], tried(world)(module))) == []
