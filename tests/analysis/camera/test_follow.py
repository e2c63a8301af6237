"""The measures of a told way, on ways worked out by hand."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from analysis import signatures
from analysis.arrays import OUTCOMES
from analysis.camera.signatures import follow, path_efficiency

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
    told = signatures.measure(dataclasses.replace(run, facts={"legs": LEGS}, world={"grain": "medium"}))
    assert {"follow.sdtw", "follow.legs", "follow.n_legs"} <= told.keys()
    run = dataclasses.replace(run.only_readable(), facts={"legs": LEGS}, outcome=np.full(run.decisions, len(OUTCOMES)))
    assert not run.counted.any() and math.isnan(follow.measure(run)["legs"])
