"""Numbers by step, against ones worked out by hand."""

from dataclasses import replace
from pathlib import Path

import pytest

import foundry
from analysis.grid.signatures.warning import measure
from analysis.load import read_records, read_run
from foundry.storing.store import find_run
from foundry.viewer.grid.by_step import DISTANCE, GROUP, REACH, SAW, WARNED, GridByStep
from foundry.viewer.resources import open_view
from made_up_runs import step, sweep, whole_run, world

FIRE = {"name": "fire1", "start": 1, "position": [0, 0]}


def test_news_go_from_one_who_perceived_on_by_those_who_were_told_a_step_earlier():
    known = GridByStep(world(fires=[FIRE]), lambda text, fires: "fire" in text)
    words = {(1, 1): "hello", (2, 2): "a fire!", (3, 0): "a fire!", (3, 1): "hello", (4, 1): "a fire!"}
    rows = [
        step(number, agent, message=words.get((number, agent)), fires=("fire1",) if (number, agent) == (2, 0) else ())
        for number in (1, 2, 3, 4, 5)
        for agent in range(4)
    ]
    deliveries = [[1, 2], [2, 3], [0, 1, 1, 2], [1, 3], [3, 0]]
    known.take(1, rows[:8], deliveries[:2])
    known.take(1, rows[:8], deliveries[:2])
    known.take(3, rows[8:], deliveries[2:])
    assert known.values[SAW] == [0, 0.25, 0.25, 0.25, 0.25]
    assert known.values[WARNED] == [0, 0, pytest.approx(1 / 3), pytest.approx(2 / 3), pytest.approx(2 / 3)]
    assert known.values[REACH] == known.values[WARNED], "who was only told at this step cannot tell at it"


def test_after_the_last_step_the_reach_is_the_one_of_the_analysis(workspace: Path):
    run = find_run(
        foundry.run("model=scripted/echo", "world.steps=12", "world.communication_distance=12", "analyze=false").path
    )
    view = open_view(run, is_warning=lambda text, fires: "1" in text)
    view.steps.grow()
    told, at_most = (view.by_step(1, 12)[name][-1] for name in (WARNED, REACH))
    view.close()
    recorded = read_run(run, read_records(run, run.summary()))
    texts = set(recorded.said[recorded.spoke].tolist())
    some, every = ({text: sign in text for text in texts} for sign in ("1", ""))
    assert told == measure(replace(recorded, labels=some))["traced_reach"]
    assert at_most == measure(replace(recorded, labels=every))["traced_reach"]
    assert 0 < told < at_most < 1


def test_groups_are_of_those_who_are_there():
    near = {0: (1,), 1: (0, 2), 2: (1,), 3: (4,), 4: (3,)}
    known = GridByStep(world(fires=[]))
    known.take(1, [step(1, agent, neighbours=near[agent]) for agent in near], [[], []])
    assert known.values[GROUP] == [0.6, None]
    assert REACH not in known.values, "there is no fire to know of"


def test_distances_count_from_where_agents_stand_to_the_nearest_fire_that_burns():
    fires = [{"name": "near", "start": 2, "position": [0, 0]}, {"name": "far", "start": 1, "position": [0, 9]}]
    known = GridByStep(world(fires=fires))
    known.take(1, [step(number, agent, x=3, y=4 * agent) for number in (1, 2) for agent in (0, 1)], [[], []])
    assert known.values[DISTANCE] == [pytest.approx((90**0.5 + 34**0.5) / 2), 4.0]


def test_a_run_has_its_numbers_in_any_order_of_asking(tmp_path: Path):
    made = sweep(tmp_path / "order", models=("first",), seeds=(0,))
    whole_run(made.runs()[0])
    view = open_view(made.runs()[0])
    view.steps_per_chunk = 2
    view.steps.grow()
    later = view.by_step(5, 6)
    assert later["moved (agents)"] == [4, 4]
    assert view.by_step(1, 6)["in cafe (agents)"] == [2, 2, 2, 0, 0, 0]
    view.close()
