"""The El Farol bar: who gets what, who is told what, and the policies whose results are known."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from foundry.records import RoundStep
from foundry.worlds.base import Answer
from foundry.worlds.rounds.bar import REPORTS, Bar, Evening
from foundry.worlds.rounds.reading import deciding
from foundry.worlds.rounds.rounds_policies import PREDICTORS, equilibrium
from scripted_rounds import scripted_run
from small_worlds import bar

GO, STAY = deciding("go"), deciding("stay")


def evening(scenario: Bar, *goers: int) -> tuple[list[RoundStep], Evening, list[list[dict[str, Any]]]]:
    world = scenario.start(0)
    records = world.advance([Answer(GO if agent in goers else STAY) for agent in range(scenario.agents)])
    steps = [record for record in records if isinstance(record, RoundStep)]
    (step_record,) = (record for record in records if isinstance(record, Evening))
    return steps, step_record, [question.observation["evenings"] for question in world.pending()]


@pytest.mark.parametrize(
    ("goers", "utilities"), [((0, 1, 2), (10, 10, 10, 5, 5)), ((0, 1, 2, 4), (0, 0, 0, 5, 0)), ((), (5,) * 5)]
)
def test_the_bar_is_fun_to_the_last_place_and_crowded_beyond_it(goers: tuple[int, ...], utilities: tuple[int, ...]):
    steps, one, _ = evening(bar(), *goers)
    assert tuple(step.utility for step in steps) == utilities
    assert (one.went, one.places) == (len(goers), 3)


def test_reports_tell_all_or_those_who_went_or_how_many_alone():
    told = {reports: evening(bar(reports=reports), 0, 1)[2] for reports in REPORTS}
    stayed = {"action": "stay", "utility": 5}
    assert [told[reports][4] for reports in REPORTS] == [
        [{"went": 2, **stayed}],
        [{"went": None, **stayed}],
        [{"went": 2, "action": None, "utility": None}],
    ]
    assert told["explicit"][0] == told["implicit"][0] == [{"went": 2, "action": "go", "utility": 10}]


@given(agents=st.integers(1, 200), hundredths=st.integers(0, 100))
def test_as_many_places_as_the_capacity_says_whatever_rounding_does(agents: int, hundredths: int):
    places = bar(agents=agents, capacity=hundredths / 100).places
    assert places == agents * hundredths // 100


def test_the_mixed_equilibrium_makes_going_and_staying_worth_the_same_and_is_pure_where_one_is_always_better():
    assert equilibrium(10, 10, 10, 0, 5) == equilibrium(10, 6, 10, 6, 5) == 1
    assert equilibrium(10, 0, 10, 0, 5) == equilibrium(10, 6, 4, 0, 5) == equilibrium(1, 0, 9, 0, 5) == 0
    found = equilibrium(10, 6, 10, 0, 5)
    assert found == pytest.approx(0.6069, abs=5e-5)
    assert 10 * binom.cdf(5, 9, found) == pytest.approx(5, abs=1e-9)
    assert binom.cdf(59, 99, equilibrium(100, 60, 3, -1, 0)) == pytest.approx(1 / 4, abs=1e-9)


def test_agents_that_predict_settle_at_the_capacity_wherever_they_begin():
    run = scripted_run("bar", "inductive", agents=100, steps=25, reports="attendance")
    attendance = [line["went"] for line in run.streams["evenings"]]
    assert abs(np.mean(attendance) - 60) < 3
    assert min(attendance) < 45 and max(attendance) > 75, "no single number is right for long, or all would use it"


def test_every_predictor_stays_within_the_crowd_and_looks_back_alone():
    past = np.array([[0, 10, 0, 10, 0, 10, 0, 10], [9, 8, 7, 6, 5, 4, 3, 2]], dtype=float)
    for predictor in PREDICTORS:
        said = predictor(past, 10)
        assert said.shape == (2,) and (said >= 0).all() and (said <= 10).all()
    assert PREDICTORS[-1](past, 10)[1] == pytest.approx(1), "eight evenings on a straight line, one further"
