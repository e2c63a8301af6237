"""`foundry new` begins parts that run as they are, with tests that pass, and writes over nothing."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from commands import refusal, succeeds
from foundry.composing.beginning import begin
from foundry.paths import shipped_parts

KINDS = sorted(folder.name for folder in shipped_parts().iterdir() if (folder / "try_it.txt").is_file())
SMALL = ("world.agents=4", "world.steps=3", "runner.workers=1", "analyze=false")
TRIED = {
    "world": ("world=own_world", "model=scripted/random"),
    "prompt": ("prompt=own_prompt", "model=scripted/random"),
    "model": ("model=own_model",),
    "policy": ("model=own_policy",),
    "signature": ("model=scripted/stay",),
    "edit": ("model=scripted/stay",),
    "form": ("world=own_form", "model=scripted/random"),
}


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a part of every kind in `mine/`."""
    folder = tmp_path_factory.mktemp("begun")
    for kind in KINDS:
        done = succeeds("new", kind, f"own_{kind}", cwd=folder)
        assert f"own_{kind}" in done.stdout, done.stderr
    return folder


def test_there_is_one_of_every_kind(begun: Path):
    assert set(KINDS) == set(TRIED)
    left = [file for file in (begun / "mine").rglob("*.*") if "art_name" in file.read_text() or "PartName" in file.name]
    assert left == []


@pytest.mark.parametrize("kind", KINDS)
def test_what_was_begun_runs(kind: str, begun: Path):
    succeeds("--config-dir", "mine", *TRIED[kind], *SMALL, f"output.dir=out_{kind}", cwd=begun)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_what_was_begun_passes_the_checks(kind: str, begun: Path):
    checked = {"policy": "model=own_policy", "signature": "own_signature", "form": "world=own_form"}
    named = checked.get(kind, f"{kind}=own_{kind}")
    done = succeeds("check", named, *SMALL[:2], "--config-dir", "mine", cwd=begun)
    assert ", 0 failed" in done.stdout, done.stdout + done.stderr


@pytest.mark.exhaustive
def test_its_own_tests_pass(begun: Path):
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", "mine", "mine"]
    done = subprocess.run(command, cwd=begun, env=dict(os.environ), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "12 passed" in done.stdout


@pytest.mark.parametrize(
    ("kind", "name", "told"),
    [
        ("word", "bar", "Kind of part 'word' not found. Did you mean 'world'?"),
        ("world", "my-bar", "such as el_farol; got 'my-bar'"),
        ("world", "class", "such as el_farol; got 'class'"),
        ("policy", "yaml", "another module has that name"),
        ("world", "bar", "conf/prompt/bar.yaml. Rename your part, for example to 'bar_2'"),
        ("prompt", "json", "conf/prompt/json.yaml. Rename your part, for example to 'json_2'"),
        ("policy", "human", "conf/model/human.yaml. Rename your part, for example to 'human_2'"),
        ("signature", "hazard", "signatures/hazard.py. Rename your part, for example to 'hazard_2'"),
    ],
)
def test_what_cannot_be_is_told_in_one_line_and_nothing_is_written(kind: str, name: str, told: str, workspace: Path):
    assert told in refusal("new", kind, name, cwd=workspace)
    assert list(workspace.iterdir()) == []


def test_nothing_is_written_over(tmp_path: Path):
    path = tmp_path / "mine" / "prompt" / "pub.yaml"
    path.parent.mkdir(parents=True)
    path.write_text("mine")
    assert "exists, and foundry does not change it" in refusal("new", "world", "pub", cwd=tmp_path)
    assert path.read_text() == "mine" and list((tmp_path / "mine").rglob("*.*")) == [path]


def test_another_folder_is_named_in_what_is_written(tmp_path: Path):
    begun = begin("model", "bar", tmp_path / "parts")
    assert f"--config-dir {tmp_path / 'parts'}" in begun.try_it
    assert all(file.is_file() and file.is_relative_to(tmp_path / "parts") for file in begun.files)
