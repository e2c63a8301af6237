"""`foundry threshold`: stages of a sweep, a bracket for each model, and one line where nothing can be looked for."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from foundry.cli import run
from foundry.storing.store import SweepFolder

SMALL = ("+sweep=critical_mass", "seed=0-2", "world.steps=6", "world.agents=12", "cache.path=answers.sqlite")


def test_every_model_gets_its_own_bracket_from_stages_that_are_sweeps(workspace: Path, capsys):
    asked = ("model=scripted/focal_name,scripted/best_response", "world.committed_name=bafu", "world.established=tazo")
    assert run(["threshold", *SMALL, *asked, "output.dir=mass", "search.until=0.2"]) == 0
    table = pd.read_csv("mass/threshold.csv").set_index("model")
    assert table.loc["scripted/focal_name", "high"] == 0 and pd.isna(table.loc["scripted/focal_name", "threshold"])
    best = table.loc["scripted/best_response"]
    assert 0 <= best["low"] < best["threshold"] < best["high"] <= 0.7 and best["high"] - best["low"] <= 0.2
    points = pd.read_csv("mass/threshold_points.csv")
    assert set(points["n"]) == {3} and set(points["share"]) >= {0, 1}
    stages = sorted(Path("mass").glob("stage-*"))
    assert len(stages) == 4 and len(SweepFolder.open(stages[0]).runs()) == 6
    written = {one: one.stat().st_mtime_ns for one in Path("mass").glob("stage-*/runs/*/run.json")}
    assert run(["threshold", *SMALL, *asked, "output.dir=mass", "search.until=0.2"]) == 0
    assert written == {one: one.stat().st_mtime_ns for one in Path("mass").glob("stage-*/runs/*/run.json")}
    assert "surely_low" in capsys.readouterr().out


@pytest.mark.parametrize(("asked", "told"), [
    (("world=naming",), "looks for no threshold"), (("+sweep=critical_mass", "search.low=1"), "give low < high"),
    (("+sweep=critical_mass", "search.setting=world.comitted"), "Did you mean 'committed'"),
    (("+sweep=critical_mass", "search.level=much"), "says nothing that can be looked for"),
    ((*SMALL, "search.measure=naming.succes", "output.dir=x"), "Did you mean 'naming.success'"),
    ((*SMALL, "search.measure=naming.success", "output.dir=y"), "is no outcome"),
])  # fmt: skip
def test_a_search_that_cannot_be_is_told_in_one_line(asked: tuple[str, ...], told: str, workspace: Path, capsys):
    assert run(["threshold", *asked, "model=scripted/best_response"]) == 2
    error = capsys.readouterr().err
    assert told in error and error.count("\n") == 1
