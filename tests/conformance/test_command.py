"""`foundry check` says of every part what holds and what is to be done, and its exit code says whether anything is."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import foundry as public
from commands import foundry
from foundry import paths

SMALL = ("world.agents=3", "world.steps=2")
GREED = """
import math
from analysis.any.any_run import AnyRun
from analysis.measure import share
NAME = "greed"
MEASURES = {"most": share("Most")}
HEADLINE = ("most",)
def measure(run: AnyRun) -> dict[str, float]:
    return {"most": %s}
"""


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    for part in ("model", "prompt", "signatures"):
        (tmp_path / "mine" / part).mkdir(parents=True)
    (tmp_path / "mine" / "model" / "forgetful.yaml").write_text(
        "_target_: forgetful.Forgetful\nname: mine\nodds: 0.5\n"
    )
    (tmp_path / "mine" / "forgetful.py").write_text(
        "from foundry import ScriptedModel\n"
        "from foundry.worlds.grid.grid_policies import act, say\n"
        "class Forgetful(ScriptedModel):\n"
        "    def __init__(self, name, odds):\n"
        "        super().__init__(name)\n"
        "    def message(self, observation, rng):\n"
        "        return say(None, reasoning='')\n"
        "    def action(self, observation, rng):\n"
        "        return act('stay', reasoning='')\n"
    )
    (tmp_path / "mine" / "signatures" / "greed.py").write_text(GREED % "1.0 if len(run.step) else math.nan")
    return tmp_path


def test_what_holds_is_said_line_by_line(tmp_path: Path):
    done = foundry("check", "world=bar", "model=scripted/random", *SMALL, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "world bar" in done.stdout and "model scripted/random" in done.stdout
    assert "is equal from a pickle" in done.stdout and ", 0 failed" in done.stdout
    assert list(tmp_path.iterdir()) == []


def test_what_does_not_hold_is_told_and_the_exit_code_is_2(mine: Path):
    done = foundry("check", "model=forgetful", *SMALL, "--config-dir", "mine", "--json", cwd=mine)
    found = json.loads(done.stdout)["findings"]
    assert done.returncode == 2
    assert [(one["check"], one["note"]) for one in found if one["status"] == "failed"] == [
        (
            "tells its settings apart",
            "with another odds the parameters() are the same: add it, or answers of both mix",
        )
    ]


@pytest.mark.slow
def test_several_of_a_kind_are_checked_each_once(tmp_path: Path):
    done = foundry("check", "model=scripted/random,scripted/stay", "seed=0-1", *SMALL, "--json", cwd=tmp_path)
    found = json.loads(done.stdout)["findings"]
    assert done.returncode == 0 and {one["part"] for one in found} == {
        "model scripted/random",
        "model scripted/stay",
    }
    assert len({(one["part"], one["check"]) for one in found}) == len(found)


@pytest.mark.parametrize("name", ["greed", "mine/signatures/greed.py"])
def test_a_signature_with_the_name_of_a_shipped_one_is_refused(name: str, mine: Path):
    file = mine / "mine" / "signatures" / "greed.py"
    file.write_text(file.read_text().replace('NAME = "greed"', 'NAME = "hazard"'))
    done = foundry("check", name, *SMALL, "--config-dir", "mine", cwd=mine)
    assert done.returncode == 2 and "greed.py has the name 'hazard'" in done.stderr
    assert "hazard.py. Rename yours, for example to 'hazard_2'" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", ["greed", "mine/signatures/greed.py"])
def test_a_signature_is_named_by_its_name_or_its_file(name: str, mine: Path):
    done = foundry("check", name, "model=scripted/random", *SMALL, "--config-dir", "mine", cwd=mine)
    assert "signature greed" in done.stdout and "measures the same twice" in done.stdout, done.stdout + done.stderr


def test_a_signature_that_calls_nothing_a_finding_fails(mine: Path):
    (mine / "mine" / "signatures" / "greed.py").write_text(GREED % "float(run.counted.mean()) if len(run.step) else 1")
    done = foundry("check", "greed", *SMALL, "--config-dir", "mine", cwd=mine)
    assert done.returncode == 2 and "is 0 in a run without any decision that counts" in done.stdout.replace("\n", " ")


@pytest.mark.parametrize(("null", "exit_code"), [(0.2, 0), (0.5, 2)])
def test_a_stated_null_is_held_against_a_policy_that_is_blind_to_all(null: float, exit_code: int, mine: Path):
    staying = (GREED % "float((run.action[run.counted] == 'stay').mean()) if run.counted.any() else math.nan").replace(
        'share("Most")', f'share("Most", Null({null}, "draws its actions"))'
    )
    (mine / "mine" / "signatures" / "greed.py").write_text(staying.replace("import share", "import Null, share"))
    done = foundry("check", "greed", "model=scripted/stay", *SMALL, "--config-dir", "mine", "--json", cwd=mine)
    found = {one["check"]: (one["status"], one["note"]) for one in json.loads(done.stdout)["findings"]}
    status, note = found["comes to its nulls"]
    assert (done.returncode, status) == (exit_code, "failed" if exit_code else "passed"), found
    assert ("'most' is 0." in note and "Null says 0.5" in note) == bool(exit_code), note


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ((), "Nothing to check"),
        (("seed=3",), "Nothing to check"),
        (("world=cafe",), "World 'cafe' not found"),
        (("greeed", "--config-dir", "mine"), "Signature 'greeed' not found. Did you mean 'greed'?"),
    ],
)
def test_what_cannot_be_checked_is_one_line(asked: tuple[str, ...], told: str, mine: Path):
    done = foundry("check", *asked, cwd=mine)
    assert done.returncode == 2 and told in done.stderr and done.stderr.count("\n") == 1


def test_the_function_returns_what_the_command_prints(mine: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(mine)
    found = public.check("model=forgetful", *SMALL, config_dir="mine")
    assert [one.check for one in found if one.status == "failed"] == ["tells its settings apart"]


@pytest.mark.slow
def test_the_example_holds_what_every_part_must_hold(tmp_path: Path):
    mine = paths.PACKAGE.parent / "examples" / "el_farol" / "mine"
    parts = ("world=el_farol", "model=mine/mixing", "prompt=el_farol", "attendance")
    done = foundry("check", *parts, "world.steps=4", "--config-dir", str(mine), "--json", cwd=tmp_path)
    found = json.loads(done.stdout)["findings"]
    assert done.returncode == 0, [one for one in found if one["status"] == "failed"]
    skipped = {one["check"] for one in found if one["status"] == "skipped"}
    needless = {"asks ahead what it asks later", "keeps its secrets", "opens with its personas"}
    assert skipped == {*needless, "has a schema for every question"}
