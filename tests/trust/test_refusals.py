"""Recorded configurations may come from anyone: what they name is built only if it is foundry's own."""

import contextlib
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from commands import foundry, refusal, succeeds
from foundry.errors import InputError, RecordError
from foundry.expansion import Condition, expand
from foundry.own_code import use
from foundry.paths import conf_dir
from foundry.running.build import build
from foundry.storing.plain import load_plain
from foundry.storing.store import SweepFolder
from foundry.trust.unknown import check_targets, own_packages
from ollama_server import OllamaServer
from trust.conftest import MIX, rewrite, run_of


class Echo:
    def __init__(self, **settings: Any) -> None:
        self.settings = settings


@pytest.mark.parametrize(
    "target",
    ["os.system", "foundry.paths.os.system", "foundry.cli.run", "foundry.models.answers.answers.Answers",
     "builtins.eval",
     "foundry.models.base.asyncio.run", "foundry.worlds.base.ABC", "foundry.models.nothing.X", "subprocess.Popen",
     "foundry.models.base.Path", "foundry.storing.store.write_atomically", ["os", "system"], None, "foundry", ""],
)  # fmt: skip
def test_a_target_that_is_not_a_part_of_foundry_is_refused(target: Any):
    for config in ({"model": {"_target_": target}}, {"world": {"deep": [{"down": {"_target_": target}}]}}):
        with pytest.raises(InputError, match="is refused"):
            check_targets(config, (), "here")


def test_a_part_in_the_wrong_place_is_refused_and_every_runner_of_foundry_is_taken():
    with pytest.raises(InputError, match="it is not a Scenario"):
        check_targets({"world": {"_target_": "foundry.prompts.prompt.Prompt"}}, (), "here")
    check_targets({"runner": {"_target_": "foundry.running.local.LocalRunner"}}, (), "here")
    check_targets({"runner": {"_target_": "foundry.running.dask.DaskRunner", "address": "tcp://x:1"}}, (), "here")
    for target in (
        "foundry.composing.preparing.LauncherRunner",
        "foundry.running.dask.SweepJob",
        "foundry.prompts.prompt.Prompt",
    ):
        with pytest.raises(InputError, match="is refused"):
            check_targets({"runner": {"_target_": target}}, (), "here")


def test_what_was_typed_says_which_packages_of_others_are_trusted_beside_it():
    config = {
        "world": {"_target_": "foundry.worlds.grid.grid_world.GridScenario", "name": "w"},
        "model": {"_target_": "market.models.Buyer", "name": "m", "of": [{"_target_": "market.Seller"}]},
        "prompt": {"_target_": "foundry.prompts.prompt.Prompt", "name": "p"},
        "sampling_seed": None,
    }
    assert own_packages(expand([], [Condition({}, config, (0,))])) == ["market.models", "market"]


@pytest.mark.parametrize("key", ["_partial_", "_args_", "_recursive_", "_convert_"])
def test_what_else_instantiation_would_do_is_refused(key: str):
    config = {"model": {"_target_": "foundry.worlds.any.any_policies.Stay", "inner": {key: True}}}
    with pytest.raises(InputError, match=f"may not use {key}"):
        check_targets(config, (), "here")


def test_trust_in_another_package_does_not_build_what_a_record_names():
    for trusted in ("antigravitx", "antigravit"):
        with pytest.raises(InputError, match="--trust-targets antigravity"):
            check_targets({"world": {"_target_": "antigravity.GridScenario"}}, (trusted,), "here")


@pytest.mark.parametrize(
    ("target", "refused"),
    [
        ("my_rooms.Room", ""),
        ("my_rooms.Thing", "it is not a Scenario"),
        ("my_rooms.subprocess.Popen", "it is not one of foundry's own"),
        ("my_rooms.make", "it is not one of foundry's own"),
        ("other_rooms.Room", "it is not one of foundry's own"),
    ],
)
def test_a_record_may_build_the_classes_of_the_folder_that_the_user_names_and_nothing_else(
    target: str, refused: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    code = (
        "import subprocess\nfrom foundry.worlds.grid.grid_world import GridScenario\n"
        "class Room(GridScenario):\n    pass\nclass Thing:\n    pass\ndef make():\n    pass\n"
    )
    for folder, name in (("mine", "my_rooms"), ("record", "other_rooms")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / f"{name}.py").write_text(code)
        monkeypatch.syspath_prepend(tmp_path / folder)
    use([tmp_path / "mine"])
    config = {"world": {"_target_": target}}
    with pytest.raises(InputError, match=refused) if refused else contextlib.nullcontext():
        check_targets(config, (), "here")


BUILDING = ("verify", "resume", "fork", "probe", "preregister", "replay", "analyze")
ONE_MOMENT = ("model=scripted/stay", "edit=no_fire", "moments=1", "repeats=1")


@pytest.mark.slow
@pytest.mark.parametrize("command", BUILDING)
def test_what_a_refusal_advises_is_an_option_of_the_command_that_refuses(
    command: str, grid_sweep: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    (tmp_path / "my_worlds.py").write_text("from foundry.worlds.grid.grid_world import GridScenario\n")
    monkeypatch.syspath_prepend(tmp_path)
    sweep = Path(shutil.copytree(grid_sweep, tmp_path / "copy"))
    for file in (sweep / "sweep.yaml", *(run.path / "config.yaml" for run in SweepFolder.open(sweep).runs())):
        file.write_text(
            file.read_text().replace("foundry.worlds.grid.grid_world.GridScenario", "my_worlds.GridScenario")
        )
    run = str(run_of(sweep, MIX).path)
    asked = {
        "verify": (str(sweep), "--workers", "1"),
        "resume": (str(sweep), "seed=9", "analyze=false"),
        "fork": (run, "--at", "2", "model=scripted/stay", "analyze=false"),
        "probe": (str(sweep), *ONE_MOMENT, "analyze=false"),
        "preregister": (str(sweep), *ONE_MOMENT, "--family", "no_fire"),
        "replay": (run, "--steps", "1"),
        "analyze": (str(sweep), "--baselines", "--only", "seed=77"),  # refused before plots are drawn
    }[command]
    refused = foundry(command, *asked, cwd=tmp_path)
    advice = re.search(r"--trust-targets my_worlds", refused.stderr)
    assert refused.returncode == 2 and advice, refused.stderr
    with OllamaServer() as server:
        done = foundry(command, *asked, *advice[0].split(), cwd=tmp_path, OLLAMA_HOST=server.url)
    if command == "analyze":
        assert "'77'" in done.stderr and "8 of 8 runs complete in" in done.stdout, done.stdout + done.stderr
    else:
        assert done.returncode == 0, done.stdout + done.stderr


@given(st.text(alphabet="\\${}:a.ocenvHOME ", max_size=24))
def test_texts_are_built_as_they_are_recorded(text: str):
    target = f"{Echo.__module__}.{Echo.__qualname__}"
    made = build({"_target_": target, "text": text, "list": [text], "inner": {"text": text}})
    assert made.settings == {"text": text, "list": [text], "inner": {"text": text}}


BOMB = "a: &a [1,1,1,1,1,1,1,1,1,1]\n" + "".join(
    f"{chr(98 + n)}: &{chr(98 + n)} [{','.join(['*' + chr(97 + n)] * 10)}]\n" for n in range(9)
)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (BOMB, "with its aliases expanded"),
        ("a: &a [*a]", "contains itself"),
        *((nested, "nested levels") for nested in ("[" * 200_000, "- " * 200_000, "? " * 200_000, '["]",' * 100_000)),
        ("a: !!python/object/apply:os.system [ls]", "cannot be read"),
        ("a: [", "cannot be read"),
        ("runs: 1\n---\nruns: 2", "cannot be read"),
        *((text, "does not describe a sweep") for text in ("", "1", "a: b", "conditions: 3\nruns: []")),
        ("conditions: [1]\nruns: []\nasked: []", "does not describe a sweep"),
    ],
)
def test_yaml_that_grows_or_nests_without_bound_or_describes_no_sweep_is_refused(
    text: str, expected: str, tmp_path: Path
):
    (tmp_path / "sweep.yaml").write_text(text)
    with pytest.raises(RecordError, match=expected):
        SweepFolder.open(tmp_path)
    refusal("status", str(tmp_path), cwd=tmp_path)


def test_shared_parts_are_read_as_before():
    assert load_plain("a: &a {b: 1}\nc: *a", "here") == {"a": {"b": 1}, "c": {"b": 1}}


def test_every_scripted_model_is_taken_from_a_record():
    for path in (conf_dir() / "model" / "scripted").glob("*.yaml"):
        check_targets({"model": load_plain(path.read_text(encoding="utf-8"), path)}, (), "recorded")


LEAKS = {"sampling_seed": "${oc.env:LEAK}", "record": {"frames": "${oc.env:LEAK}"}}


@pytest.mark.parametrize("key", LEAKS)
def test_nothing_of_a_record_is_looked_up_in_the_environment(key: str, copied: Path, tmp_path: Path):
    fork = ("fork", str(run_of(copied, MIX).path), "--at", "2", "model=scripted/stay", "analyze=false")
    rewrite(copied, lambda content: content["conditions"][1]["config"].update({key: LEAKS[key]}))
    line = refusal(*fork, cwd=tmp_path, LEAK="leaked")
    assert "does not describe a sweep" in line and "leaked" not in line


@pytest.mark.parametrize("command", ["fork", "probe", "resume"])
def test_texts_of_a_record_are_composed_to_the_letter(command: str, copied: Path, tmp_path: Path):
    named, pinned = "${oc.env:LEAK} \\${x} ???", ["${oc.env:LEAK}", "a, ']"]

    def write(content: dict[str, Any]) -> None:
        for condition in content["conditions"]:
            condition["config"]["world"]["name"] = condition["config"]["prompt"]["name"] = named
            condition["config"]["baselines"] = pinned

    rewrite(copied, write)
    run = str(run_of(copied, MIX).path)
    asked = {
        "fork": (run, "--at", "2", "output.dir=made"),
        "probe": (str(copied), "moments=1", "repeats=1", "output.dir=made"),
        "resume": (str(copied),),
    }[command]
    asked += ("model=scripted/stay", "analyze=false", "runner.workers=1")
    succeeds(command, *asked, cwd=tmp_path, LEAK="leaked")
    made = copied if command == "resume" else tmp_path / "made"
    assert "leaked" not in (made / "sweep.yaml").read_text()
    for recorded in SweepFolder.open(made).runs():
        config = recorded.config()
        world = config["world"].get("source", config["world"])
        assert config["baselines"] == pinned and world["name"] == config["prompt"]["name"] == named


@pytest.mark.parametrize("group", ["world", "model", "prompt"])
def test_a_record_names_no_further_files_to_compose(group: str, copied: Path, tmp_path: Path):
    further = {"defaults": ["_self_", {"/model@inner": "${oc.env:LEAK}"}]}
    rewrite(copied, lambda content: content["conditions"][1]["config"][group].update(further))
    fork = ("fork", str(run_of(copied, MIX).path), "--at", "2", "analyze=false")
    assert "no " + group + " has a setting 'defaults'" in refusal(*fork, cwd=tmp_path, LEAK="leaked")
