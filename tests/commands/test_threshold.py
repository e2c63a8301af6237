"""`foundry threshold`: stages of a sweep, a bracket for each model, and one line where nothing can be looked for."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from commands import foundry
from foundry.cli import run
from foundry.storing.store import SweepFolder
from ollama_cases import in_turn, refused
from ollama_server import OllamaServer

SMALL = (
    "+sweep=critical_mass",
    "seed=0-1",
    "world.steps=6",
    "world.agents=6",
    "world.memory=1",
    "cache.path=answers.sqlite",
)
POLICIES = "model=scripted/focal_name,scripted/best_response"
ASKED = (*SMALL, POLICIES, "world.committed_name=bafu", "world.established=tazo", "output.dir=mass", "search.until=0.4")


@pytest.mark.slow
def test_every_model_gets_its_own_bracket_from_stages_that_are_sweeps(workspace: Path, capsys):
    assert run(["threshold", *ASKED]) == 0
    table = pd.read_csv("mass/threshold.csv").set_index("model")
    assert table.loc["scripted/focal_name", "high"] == 0 and pd.isna(table.loc["scripted/focal_name", "threshold"])
    best = table.loc["scripted/best_response"]
    assert (best["low_count"], best["high_count"]) in ((0, 2), (2, 4)) and best["low"] < best["threshold"] < best[
        "high"
    ]
    points = pd.read_csv("mass/threshold_points.csv")
    assert set(points["n"]) == {2} and set(points["share"]) >= {0, 1}
    stages = [SweepFolder.open(stage) for stage in sorted(Path("mass").glob("stage-*"))]
    assert [len(stage.runs()) for stage in stages] == [4, 4, 2] and not any(one.analysis_dir.exists() for one in stages)
    shares = [{one.factors["world.committed"] * 6 for one in stage.sweep.conditions} for stage in stages]
    assert shares == [{0}, {4}, {2}]
    assert "surely_low" in capsys.readouterr().out


def test_a_share_of_agents_is_told_by_whole_agents_and_no_finer(workspace: Path, capsys):
    asked = (one for one in ASKED if one not in ("search.until=0.4", POLICIES))
    assert run(["threshold", *asked, "model=scripted/best_response", "search.until=0.02"]) == 0
    found = pd.read_csv("mass/threshold.csv").iloc[0]
    assert found["high_count"] == found["low_count"] + 1
    played = pd.read_csv("mass/threshold_points.csv")["world.committed"] * 6
    assert played.tolist() == pytest.approx(played.round().tolist()) and len(played) <= 4
    assert played.is_monotonic_increasing
    assert "nothing lies between two neighbouring counts" in capsys.readouterr().out


def test_a_run_that_fails_ends_the_search_at_its_stage_and_the_same_command_goes_on(workspace: Path):
    asked = ("threshold", *ASKED, "model=llama3.2")
    with OllamaServer(in_turn(refused(400, "no more for today"), '{"action": "tazo"}')) as server:
        failed = foundry(*asked, cwd=workspace, OLLAMA_HOST=server.url)
        assert failed.returncode == 3, failed.stdout + failed.stderr
        assert "1 of 2 runs complete in mass/stage-1" in failed.stdout and failed.stderr == ""
        assert [one.name for one in Path("mass").iterdir()] == ["stage-1"]
        done = foundry(*asked, cwd=workspace, OLLAMA_HOST=server.url)
    assert done.returncode == 0 and pd.read_csv("mass/threshold_points.csv")["n"].tolist() == [2, 2]


@pytest.mark.exhaustive
def test_the_same_command_plays_nothing_again(workspace: Path):
    assert run(["threshold", *ASKED]) == 0
    written = {one: one.stat().st_mtime_ns for one in Path("mass").glob("stage-*/runs/*/run.json")}
    assert run(["threshold", *ASKED]) == 0
    assert written == {one: one.stat().st_mtime_ns for one in Path("mass").glob("stage-*/runs/*/run.json")}


@pytest.mark.parametrize(("asked", "told"), [
    (("world=naming",), "looks for no threshold"),
    (("+sweep=critical_mass", "search.low=1"), "give low < high"),
    (("+sweep=critical_mass", "search.until=0"), "until > 0"),
    (("+sweep=critical_mass", "search.level=1"), "a level between 0 and 1"),
    (("+sweep=critical_mass", "search.of=world.committed"), "is a whole number from 1"),
    (("+sweep=critical_mass", "search.setting=world.comitted"), "Did you mean 'committed'"),
    (("+sweep=critical_mass", "search.of=world.agent"), "Did you mean 'agents'"),
    (("+sweep=critical_mass", "search.of=world.protocol"), "is a whole number"),
    (("+sweep=critical_mass", "search.low=0.01", "search.high=0.02"), "No two whole counts"),
    ((*SMALL, "search.measure=naming.success", "output.dir=y"), "is no outcome"),
])  # fmt: skip
def test_a_search_that_cannot_be_is_told_in_one_line(asked: tuple[str, ...], told: str, workspace: Path, capsys):
    assert run(["threshold", *asked, "model=scripted/best_response"]) == 2
    error = capsys.readouterr().err
    assert told in error and error.count("\n") == 1
