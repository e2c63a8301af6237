"""Runs beside their twins, which nobody tells of fires."""

from __future__ import annotations

import re

import pytest

from analysis import analyze
from foundry.cli import run
from foundry.storing.store import SweepFolder

COLUMNS = ["hazard.away_beyond_untold", "hazard.distance_beyond_untold", "hazard.away_beyond_untold_readable"]


@pytest.mark.slow
def test_a_told_run_is_held_against_its_untold_twin_of_the_same_model_and_seed(workspace):
    small = ["world.steps=12", "world.agents=6", "analyze=false"]
    told = ["-m", "model=scripted/avoid,scripted/random", "seed=0-1", *small]
    assert run([*told, "output.dir=told"]) == 0
    assert run([*told, "+world.tell_fires=false", "output.dir=untold"]) == 0
    assert not {*COLUMNS} & {*analyze(["told"], plots=False).runs}
    assert not {*COLUMNS} & {*analyze(["untold"], plots=False).runs}
    runs = analyze(["told", "untold"], plots=False, only=["model=scripted/avoid,scripted/random"]).runs
    rows = runs.set_index(["sweep", "model", "seed"]).sort_index()
    assert (rows.loc["untold", COLUMNS] == 0).all(axis=None)
    assert (rows.loc[("told", "scripted/random"), COLUMNS] == 0).all(axis=None), "it goes the same ways in both"
    blind = rows["hazard.away_beyond_blind"]
    differences = blind.loc["told", "scripted/avoid"] - blind.loc["untold", "scripted/avoid"]
    avoids = rows.loc[("told", "scripted/avoid"), "hazard.away_beyond_untold"]
    assert avoids.tolist() == differences.tolist() and avoids.min() > 0.2


@pytest.mark.slow
def test_nobody_is_told_of_fires_that_burn_and_hurt_all_the_same(workspace):
    asked = ["model=scripted/echo", "seed=0", "world.steps=6", "+world.tell_fires=false", "analyze=false"]
    assert run([*asked, "output.dir=plain"]) == 0
    assert run(["world=evacuation", *asked, "world.steps=25", "output.dir=spreading"]) == 0
    plain, spreading = (SweepFolder.open(name).runs()[0] for name in ("plain", "spreading"))
    asked_for = {
        folder.id: "\n".join(message["content"] for call in folder.calls() for message in call.messages)
        for folder in (plain, spreading)
    }
    assert b'"fires":["' not in plain.steps_bytes() + spreading.steps_bytes()
    assert "fire1" not in asked_for[plain.id]
    seen = re.findall(r"^[#.@AE?*]{11}$", asked_for[spreading.id], re.MULTILINE)
    assert len(seen) > 100 and not any("*" in row for row in seen)
    assert b'"lost":"fire"' in spreading.steps_bytes()


@pytest.mark.parametrize(("changes", "offered"), [([], True), (["+world.tell_fires=true,false"], False)])
def test_a_plan_offers_the_untold_arm_where_the_sweep_has_none(
    changes: list[str], offered: bool, workspace, capsys: pytest.CaptureFixture[str]
):
    assert run(["plan", "-m", "model=scripted/random", "seed=0-1", *changes]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if "untold arm" in line]
    assert len(lines) == offered and all("+world.tell_fires=false" in line for line in lines)
