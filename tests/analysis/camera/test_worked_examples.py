"""The formulas against worked examples that were checked with independent libraries."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from analysis.camera.paths import ndtw, resampled, soft_spl, spl, straightness
from analysis.camera.signatures.recognition import agreement
from analysis.camera.signatures.recovery import find_detours, wrong_steps

EXAMPLES = json.loads(Path(__file__).with_name("worked_examples.json").read_text(encoding="utf-8"))


def example(name: str):
    return EXAMPLES[name]["inputs"], EXAMPLES[name]["expected"]


def close(expected: object) -> object:
    return pytest.approx(expected, abs=1e-9, rel=1e-9)


def test_success_and_progress_are_weighted_by_path_length_where_there_is_a_way():
    inputs, expected = example("spl")
    values = [spl(*episode) for episode in inputs["episodes_success_l_p"]]
    assert values == close([0.8, 0, 1])
    assert np.mean(values) == close(expected)
    inputs, expected = example("soft_spl")
    assert soft_spl(inputs["end_geodesic"], inputs["start_geodesic"], inputs["path_length"]) == close(expected)
    for shortest in (0.0, math.nan):
        assert math.isnan(spl(1, shortest, 3.0))
        assert math.isnan(soft_spl(0.0, shortest, 3.0))
    assert math.isnan(soft_spl(math.nan, 5.0, 3.0))
    assert soft_spl(9.0, 5.0, 3.0) == 0


def test_paths_have_straightness_warping_and_even_points():
    inputs, expected = example("straightness_index")
    path = np.array(inputs["path"])
    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    assert straightness(path, length) == close(expected)
    assert math.isnan(straightness(path, 0.0))
    inputs, expected = example("ndtw")
    path, reference = np.array(inputs["path"]), np.array(inputs["reference"])
    assert ndtw(path, reference, inputs["d_th"]) == close(expected)
    assert ndtw(reference, reference, 1.0) == 1
    points = resampled(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), 0.3)
    assert points[0].tolist() == [0, 0]
    assert points[-1].tolist() == [1, 1]
    assert len(points) == 8
    assert resampled(np.zeros((3, 2)), 0.3).tolist() == [[0, 0]]


def test_recovery_from_wrong_steps():
    inputs, expected = example("recovery")
    distances = np.array(inputs["geodesic_to_goal"], dtype=np.float64)
    detours = find_detours(distances)
    assert int(wrong_steps(distances).sum()) == expected["n_wrong_steps"]
    assert wrong_steps(distances).mean() == close(expected["wrong_rate"])
    assert len(detours) == expected["episodes"]
    assert [one.steps for one in detours] == expected["ttr"]
    assert [int(one.recovered) for one in detours] == expected["observed"]
    assert sum(one.recovered for one in detours) == expected["recovered"]
    assert max(one.excess for one in detours) == close(expected["max_excess"])


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
    found = np.array(distances)
    assert wrong_steps(found).tolist() == wrong
    assert [one.recovered for one in find_detours(found)] == recovered


def test_without_wrong_steps_there_is_no_detour():
    assert find_detours(np.array([3.0, 2.0, 2.0, 1.0])) == []
    assert find_detours(np.array([])) == []
    assert find_detours(np.array([2.0, 2.0 + 1e-6, 2.0])) == []


def test_recognition():
    inputs, expected = example("object_recognition")
    names = sorted({*inputs["truth"], *inputs["mentioned"]})
    found = agreement(
        np.array([name in inputs["mentioned"] for name in names]), np.array([name in inputs["truth"] for name in names])
    )
    wanted = {"hallucinated": "chair_i", "precision": "precision", "recall": "recall", "f1": "f1", "miss_rate": "miss"}
    assert {name: found[name] for name in wanted} == close({name: expected[key] for name, key in wanted.items()})
