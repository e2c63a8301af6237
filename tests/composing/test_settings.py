"""What a command line may set, and what a schema may offer: everything else is one line, before anything is made."""

import re
from pathlib import Path
from typing import Any

import pytest

from commands import foundry, refusal, succeeds
from foundry.composing.compose import compose
from foundry.composing.preflight import check_schemas, first_questions, scenario_of
from foundry.errors import InputError, not_found
from foundry.storing.store import SweepFolder

TINY = ("model=scripted/random", "world.agents=2", "world.steps=2", "analyze=false")
REFUSED = {
    "runner.open_runs=0": "runner.open_runs must be a whole number from 1; got 0",
    "runner.ahead=maybe": "runner.ahead=maybe is neither true nor false",
    "runner.workers=0": "whole number from 1",
    "runner.workers=true": "whole number from 1",
    "runner=null": "Available: dask, local",
    "runner=joblib": "Runner 'joblib' not found. Available: dask, local",
    "record.frames=-1": "record.frames must be true, false or a number of steps; got -1",
    "record=5": "record.frames=",
    "cache.path=null": "cache.path must be a path of a file; got None",
    "cache=null": "cache.path=",
    "output=null": "output.dir=",
    "output.dir=[1]": "output.dir must be a path of a file; got [1]",
    "analyze=maybe": "must be true, false or baselines; got maybe",
    "view=always": "must be null or live",
    "world.agents=1000000": "at most 20,000",
    "model=null": "Model 'null' not found",
    "world=7": "World '7' not found",
    "world=[1]": "Available: bar",
    "~model": "No model is chosen",
    "~runner": "No runner is chosen",
}
CONFIGS = {
    "list": ("[1, 2]", "must contain lines"),
    "text": ("just text", "must contain lines"),
    "empty": ("", "must contain lines"),
    "aimless": ("name: x", "_target_: ..."),
    "numbered": ("{name: x, _target_: 7}", "_target_: ..."),
    "nameless": ("_target_: foundry.worlds.grid.grid_world.GridScenario", "needs a line 'name: ...'"),
}
HELD = "model.format=schema"
MIX = "model=mix/llama3.2@50%+qwen3@50%"


def refused(*arguments: str, cwd: Path) -> str:
    """Run a command line that must change nothing; return its one line."""
    before = sorted(cwd.rglob("*"))
    line = refusal(*arguments, cwd=cwd)
    assert sorted(cwd.rglob("*")) == before
    return line


@pytest.mark.parametrize("override", REFUSED)
def test_a_setting_that_cannot_be_is_refused_before_anything_is_made(override: str, tmp_path: Path):
    # Hydra takes no override of a part that is deleted beside it.
    others = [one for one in TINY if not override.startswith("~") or not one.startswith(override[1:])]
    assert REFUSED[override] in refused(*others, override, cwd=tmp_path)


def test_of_many_names_those_most_like_an_unknown_one_are_listed_and_the_others_counted(tmp_path: Path):
    line = refused(*TINY, "+world.agnets=3", cwd=tmp_path)
    found = re.search(r"Did you mean 'agents'\? Available: (.*) and \d+ more\.", line)
    assert found and "agents" in found[1].split(", ") and len(found[1].split(", ")) == 10
    runs = [f"run-{number}" for number in range(100)]
    assert str(not_found("Run", "XYZ", runs)).endswith(" and 60 more.")
    assert str(not_found("Run", "XYZ", runs[:40])).endswith(f"Available: {', '.join(sorted(runs[:40]))}.")


@pytest.mark.parametrize("name", CONFIGS)
def test_a_file_of_settings_that_builds_nothing_is_refused_with_what_it_lacks(name: str, tmp_path: Path):
    text, expected = CONFIGS[name]
    (tmp_path / "mine" / "world").mkdir(parents=True)
    (tmp_path / "mine" / "world" / "odd.yaml").write_text(text)
    line = refused("--config-dir", "mine", "world=odd", "model=scripted/random", cwd=tmp_path)
    assert expected in line and "world" in line


def test_what_is_no_name_or_no_command_is_refused_in_a_sweep_and_behind_ones_own_folder_too(tmp_path: Path):
    line = refused("-m", *TINY[1:], "model=scripted/random,null", cwd=tmp_path)
    assert "Model 'scripted/random,null' not found" in line
    (tmp_path / "mine").mkdir()
    assert "Did you mean 'plan'" in refused("--config-dir", "mine", "plann", cwd=tmp_path)


def test_a_folder_named_by_a_number_has_that_name(tmp_path: Path):
    succeeds(*TINY, "output.dir=2026", "cache.path=7", cwd=tmp_path)
    assert (tmp_path / "2026" / "sweep.yaml").exists()
    assert Path(SweepFolder.open(tmp_path / "2026").settings["cache"]["path"]).name == "7"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("flag", "command"),
    [(("--config-dir=mine",), ("plan", "--prompt")), (("-cd", "mine"), ("-m",)), (("--config-dir", "mine"), ())],
)
def test_ones_own_folder_may_be_named_before_or_behind_a_command(
    flag: tuple[str, ...], command: tuple[str, ...], tmp_path: Path
):
    (tmp_path / "mine" / "world").mkdir(parents=True)
    (tmp_path / "mine" / "world" / "own.yaml").write_text("defaults: [cafe_library, _self_]\nagents: 3\nsteps: 1\n")
    asked = ("world=own", "model=scripted/random")
    run = () if "plan" in command else ("analyze=false",)
    before = foundry(*flag, *command, *asked, *run, "output.dir=a", cwd=tmp_path)
    behind = foundry(*command, *asked, *run, "output.dir=b", *flag, cwd=tmp_path)
    assert before.returncode == behind.returncode == 0, before.stderr + behind.stderr
    printed = [re.sub(r" in [ab]\b(, \d+ s)?", "", done.stdout) for done in (before, behind)]  # folder and time
    assert printed[0] == printed[1] != ""


def test_a_fire_that_starts_after_the_last_step_is_told_of(tmp_path: Path):
    for command in (("plan",), ()):
        done = foundry(*command, *TINY[:2], "world.steps=4", "analyze=false", cwd=tmp_path)
        told = [line for line in done.stdout.splitlines() if "fire2" in line]
        assert told == ["world 'cafe_library': fire 'fire2' starts at step 5, but the run ends at step 4"]


def checked(*overrides: str) -> None:
    composed = compose(overrides if MIX in overrides else ["model=llama3.2", *overrides])
    config: dict[str, Any] = dict(composed.conditions[0].config)
    scenario = scenario_of(config)
    check_schemas(config["model"], scenario, tuple(first_questions(scenario, 0)))


@pytest.mark.parametrize(
    "world", ["cafe_library", "evacuation", "survival", "bar", "fishery", "public_goods_punishment"]
)
def test_the_schema_that_a_world_chooses_offers_what_it_reads(world: str):
    checked(HELD, f"world={world}")


@pytest.mark.parametrize(
    ("overrides", "offered", "left"),
    [
        ((HELD, "world=survival", "world.sharing=false"), "share", "[move,stay,gather,attack,reproduce]"),
        ((HELD, "schema=survival"), "gather, share, attack, reproduce", "[move,stay]"),
        ((MIX, "model.members.m2.model.format=schema", "schema=survival"), "gather, share, attack, reproduce", ""),
    ],
)
def test_what_is_switched_off_is_not_offered(overrides: tuple[str, ...], offered: str, left: str):
    with pytest.raises(InputError, match=f"choose {offered}\\..*does not accept") as refused:
        checked(*overrides)
    assert left in str(refused.value) and "\n" not in str(refused.value)


def test_a_schema_that_leaves_it_out_is_taken_and_so_is_free_text():
    checked(HELD, "world=survival", "world.sharing=false", "schema.action.properties.action.enum=[move,stay,gather]")
    checked("world=survival", "world.sharing=false")
