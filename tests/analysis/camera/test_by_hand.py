"""Measures of 3D runs on ways, answers and detours worked out by hand."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from analysis import signatures
from analysis.arrays import OUTCOMES
from analysis.camera.signatures import follow, map_probe, path_efficiency
from analysis.camera.signatures.path_efficiency import resampled, spl
from analysis.camera.signatures.recovery import find_detours, wrong_steps

LEGS = [
    {"turn": 0, "metres": 6.0, "end": (6.0, 0.0, 0.0), "towards": None, "near": None, "side": None},
    {"turn": 90, "metres": 4.0, "end": (6.0, 4.0, 0.0), "towards": None, "near": None, "side": None},
]


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ([(0, 0), (6, 0), (6, 4)], 2),  # as told
        ([(0, 0), (6, 4)], 0),  # across: 3.3 m from the corner
        ([(0, 0), (6, 0.9), (6, 3.2)], 2),  # within a metre of both ends
        ([(0, 0), (9, 0)], 1),  # past the first end and on
        ([(0, 0), (0, 4), (6, 4), (6, 0)], 1),  # the other way round: the second leg's end came first
        ([(0, 0)], 0),
    ],
)
def test_a_leg_is_walked_when_its_end_is_come_near_to_after_those_before(
    path: list[tuple[float, float]], expected: int
):
    ends = np.array([leg["end"][:2] for leg in LEGS])
    assert follow.walked(np.array(path, dtype=np.float64), ends) == expected


def test_likeness_counts_only_where_the_agent_arrived(camera):
    for stop in (True, False):
        run = dataclasses.replace(camera(3, stop=stop).run, facts={"legs": LEGS})
        arrived = path_efficiency.measure(run)
        assert arrived["success"] == float(stop) and arrived["ndtw"] > 0
        assert follow.measure(run)["sdtw"] == arrived["success"] * arrived["ndtw"]


def test_worlds_that_tell_no_way_have_no_such_columns_and_no_decision_walks_no_leg(camera):
    run = camera(3).run
    assert not any(name.startswith("follow.") for name in signatures.measure(run))
    measures = signatures.measure(dataclasses.replace(run, facts={"legs": LEGS}, world={"grain": "medium"}))
    assert {"follow.sdtw", "follow.legs", "follow.n_legs"} <= measures.keys()
    run = dataclasses.replace(run.only_readable(), facts={"legs": LEGS}, outcome=np.full(run.decisions, len(OUTCOMES)))
    assert not run.counted.any() and math.isnan(follow.measure(run)["legs"])


WORLD = {"questions": ["nearer", "side", "count", "distance"]}


def answer(kind: str, said: Any, truth: Any, chance: float | None = None, scale: float | None = None) -> dict[str, Any]:
    return {"kind": kind, "answer": said, "truth": truth, "chance": chance, "scale": scale}


ANSWERS = (
    answer("nearer", "A", "A", 0.5),
    answer("side", None, "left", 0.5),
    answer("count", 2, 2, 0.25),
    answer("distance", 3.0, 4.5, scale=3.0),
)


def test_what_is_right_is_counted_beyond_chance_and_what_could_not_be_read_is_wrong_or_left_out(camera):
    run = dataclasses.replace(camera(3).run, answers=ANSWERS, world=WORLD)
    measures = map_probe.measure(run)
    assert measures["accuracy"] == pytest.approx(2 / 3) and measures["chance"] == pytest.approx(5 / 12)
    assert measures["above_chance"] == pytest.approx(1 / 4)
    assert (measures["accuracy_nearer"], measures["accuracy_side"], measures["chance_count"]) == (1, 0, 0.25)
    assert (measures["distance_error"], measures["distance_relative"]) == (1.5, 0.5)
    assert (measures["n_questions"], measures["n_distances"]) == (3, 1)
    run = dataclasses.replace(camera(3).run, answers=ANSWERS, world=WORLD)
    measures = map_probe.measure(run.only_readable())
    assert measures["accuracy"] == 1 and math.isnan(measures["accuracy_side"]) and measures["n_questions"] == 2
    silent = (answer("distance", None, 4.5, scale=3.0),)
    assert math.isnan(map_probe.measure(dataclasses.replace(run, answers=silent))["distance_error"])
    assert not run.all_readable
    assert not any(name.startswith("map_probe.") for name in signatures.measure(camera(3).run))


@pytest.mark.parametrize(
    ("distances", "wrong", "recovered"),
    [
        ([1.0, 1.0009, 1.0018], [False, False], []),
        ([1.0, 1.0011, 1.0], [True, False], [True]),
        ([1.0, 2.0, 1.0009], [True, False], [True]),
        ([1.0, 2.0, 1.0011], [True, False], [False]),
        ([0.0, 0.001, 0.001], [True, False], [False]),
    ],
)
def test_a_millimetre_is_the_least_that_counts(distances: list[float], wrong: list[bool], recovered: list[bool]):
    assert wrong_steps(np.array(distances)).tolist() == wrong
    assert [detour.recovered for detour in find_detours(np.array(distances))] == recovered


def test_without_steps_there_is_no_detour_and_without_a_way_one_point():
    assert find_detours(np.array([])) == []
    assert resampled(np.zeros((3, 2)), 0.3).tolist() == [[0, 0]]


def test_success_is_weighted_by_path_length_where_there_is_a_way():
    assert [spl(*episode) for episode in ((1, 8.0, 10.0), (0, 8.0, 8.0), (1, 5.0, 4.0))] == [0.8, 0, 1]
    assert math.isnan(spl(1, 0.0, 3.0)) and math.isnan(spl(1, math.nan, 3.0))
