"""The events that an analysis writes, held against the records, and runs beside twins that nobody tells of fires."""

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import foundry
from analysis import analyze
from analysis.camera.camera_events import events as camera_events
from foundry.cli import run
from foundry.storing.store import SweepFolder
from walkers import Habits, make_condition, rewrite_run


def analysed(folder: Path) -> foundry.Loaded:
    foundry.analyze(str(folder), plots=False)  # a text is the name of one folder
    return foundry.load(folder)


def of(sweep: foundry.Loaded, event: str) -> pd.DataFrame:
    return sweep.events[sweep.events["event"] == event]


def test_events_of_a_2d_world_are_those_of_its_records(make_sweep):
    folder = make_sweep([make_condition("a", range(3))], {"a": Habits(unreadable=0.2)})
    rewrite_run(folder.runs()[2], "failed")
    with pytest.raises(foundry.InputError, match=r"events.parquet' does not exist. Run foundry analyze"):
        _ = foundry.load(folder.path).events
    sweep = analysed(folder.path)
    failed = of(sweep, "failed").iloc[0]
    assert failed["run"] == folder.runs()[2].id and pd.isna(failed["agent"])
    assert failed["step"] == sweep.steps[sweep.steps["run"] == failed["run"]]["step"].max()
    steps = sweep.steps[sweep.steps["run"] != failed["run"]]
    unread = sum(int((~steps[name].isin(["chosen", "repaired"])).sum()) for name in ("outcome", "message_outcome"))
    assert len(of(sweep, "unreadable")) == unread > 0
    entered = {(row.run, row.agent, f"agent {row.agent} arrives at cafe") for row in inside_after(steps, "cafe")}
    arrived = of(sweep, "arrived")
    told = {(row.run, row.agent, row.text) for row in arrived.itertuples() if row.text.endswith("cafe")}
    assert told == entered != set() and not arrived.duplicated(["run", "agent", "text"]).any()
    for row in of(sweep, "crowded").itertuples():
        place, count = row.text.split(" is crowded: ")[0], int(row.text.split(": ")[1].split()[0])
        following = steps[(steps["run"] == row.run) & (steps["step"] == row.step + 1)]
        assert following.empty or (following["place"] == place).sum() == count
    for row in of(sweep, "first_warning").itertuples():
        said = steps[(steps["run"] == row.run) & (steps["step"] == row.step) & (steps["agent"] == row.agent)]
        assert said["message"].item() in row.text
    assert of(sweep, "fled").groupby(["run", "agent"]).size().max() == 1


def inside_after(steps: pd.DataFrame, place: str) -> list[Any]:
    """Return the steps by which agents come into a place, told from where they are at the next one."""
    ordered = steps.sort_values(["run", "agent", "step"])
    following = ordered.groupby(["run", "agent"])["place"].shift(-1)
    last = ordered["step"] == ordered["step"].max()
    cafe = (ordered["x_next"] + 3).abs().le(1) & ordered["y_next"].abs().le(2)
    assert (following[~last].eq(place) == cafe[~last]).all()
    return list(ordered[cafe & ordered["place"].ne(place) & ordered["moved"]].itertuples())


@pytest.mark.slow
def test_events_of_games_say_when_a_stock_collapses_a_bar_is_crowded_and_choices_part(tmp_path):
    asked = ("model=scripted/random", "world=bar,fishery", "seed=0-1", f"output.dir={tmp_path / 'games'}")
    sweep = analysed(foundry.sweep(*asked).path)
    for row in of(sweep, "collapsed").itertuples():
        stock = sweep.streams["stock"]
        last = stock[stock["run"] == row.run].iloc[-1]
        text = f"the stock collapses: {last['after']} of {last['before']} tons are left"
        assert (row.step, row.text) == (last["step"], text)
    evenings = sweep.streams["evenings"].sort_values(["run", "step"])
    is_full = evenings["went"] > evenings["places"]
    begins = evenings[is_full & ~is_full.groupby(evenings["run"]).shift(fill_value=False)]
    told, right = (set(zip(rows["run"], rows["step"], strict=True)) for rows in (of(sweep, "crowded"), begins))
    assert told == right != set()
    assert len(of(sweep, "collapsed")) == 2 and set(of(sweep, "first_unlike")["step"]) == {1}


def test_events_of_a_3d_world_are_the_arrival_and_the_beginning_of_each_stop():
    run = SimpleNamespace(
        has_target=True,
        success=np.array([False, False, True, True]),
        episode=SimpleNamespace(target="door"),
        collided=np.array([True, True, False, True]),
        boundary=["wall", "wall", None, "bounds"],
    )
    told = [(camera_event.step, camera_event.event, camera_event.text) for camera_event in camera_events(run)]
    assert told == [
        (3, "arrived", "arrives at door"), (1, "collided", "is stopped by wall"),
        (4, "scene_ended", "is stopped by the bounds of the scene"),
    ]  # fmt: skip


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
    lines = [line for line in capsys.readouterr().out.splitlines() if "no agent is told" in line]
    assert len(lines) == offered and all("+world.tell_fires=false" in line for line in lines)
