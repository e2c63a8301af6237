"""The events that an analysis writes, held against the records that they are told from."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import foundry
from analysis.camera.camera_events import events as camera_events
from analysis.form import FormAnalysis, form_of


def analysed(folder: Path) -> foundry.Loaded:
    foundry.analyze(folder, plots=False)
    return foundry.load(folder)


def of(sweep: foundry.Loaded, event: str) -> pd.DataFrame:
    return sweep.events[sweep.events["event"] == event]


def test_events_of_a_2d_world_are_those_of_its_records(make_sweep, make_condition, make_habits, rewrite_run):
    folder = make_sweep([make_condition("a", range(3))], {"a": make_habits(unreadable=0.2)})
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
    told = [(one.step, one.event, one.text) for one in camera_events(run)]
    assert told == [
        (3, "arrived", "arrives at door"), (1, "collided", "is stopped by wall"),
        (4, "scene_ended", "is stopped by the bounds of the scene"),
    ]  # fmt: skip


def test_a_form_of_ones_own_may_leave_events_out():
    grid = form_of("grid")
    assert FormAnalysis("own", grid.run, grid.read).events(None) == ()
