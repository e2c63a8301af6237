"""Ways from place to place, drawn by hand."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from analysis.arrays import OUTCOMES
from analysis.grid.signatures import path_efficiency
from foundry.records import Outcome

CAFE = {"name": "cafe", "type": "cafe", "center": [0, 0], "extent": [0, 0], "capacity": 1}
BAR = {"name": "bar", "type": "cafe", "center": [4, 0], "extent": [1, 1], "capacity": 1}


@pytest.fixture
def walked(recorded):
    """Return a function that gives the run of one agent along these cells; an `unread` step could not be read."""

    def make(*cells: tuple[int, int], unread: tuple[int, ...] = ()):
        steps = len(cells) - 1
        run = recorded(seed=len(cells), agents=1, steps=steps, places=[CAFE, BAR], fires=[]).run
        x, y = np.array(cells).T[:, :, None]
        outcome = np.full((steps, 1), OUTCOMES.index(Outcome.CHOSEN))
        outcome[list(unread)] = OUTCOMES.index(Outcome.EMPTY)
        moved = (np.diff(x, axis=0) != 0) | (np.diff(y, axis=0) != 0)
        return dataclasses.replace(run, x=x, y=y, place=run.world.areas(x, y), moved=moved, outcome=outcome)

    return make


def test_a_way_from_outside_takes_as_long_as_it_takes_with_and_without_waits(walked):
    found = path_efficiency.measure(walked((-3, 0), (-2, 0), (-2, 0), (-2, 1), (-1, 1), (0, 1), (0, 0)))
    assert (found["n_trips"], found["n_returns"], found["arrived"]) == (1, 0, 1)
    assert found["trip_efficiency"] == pytest.approx(3 / 6)
    assert found["trip_efficiency_moving"] == pytest.approx(3 / 5)


def test_a_wait_that_the_agent_did_not_choose_is_left_out_of_readable_trips(walked):
    run = walked((-2, 0), (-2, 0), (-1, 0), (0, 0), unread=(0,))
    assert path_efficiency.measure(run)["trip_efficiency"] == pytest.approx(2 / 3)
    assert path_efficiency.measure(run.only_readable())["trip_efficiency"] == 1


def test_a_trip_between_places_begins_where_the_first_one_was_left_for_good(walked):
    found = path_efficiency.measure(walked((0, 0), (0, 0), (0, 0), (1, 0), (2, 0), (3, 0), (4, 0)))
    assert (found["n_trips"], found["trip_efficiency"]) == (1, 1)
    found = path_efficiency.measure(walked((0, 0), (1, 0), (0, 0), (1, 0), (2, 0), (3, 0)))
    assert (found["n_trips"], found["n_returns"], found["trip_efficiency"]) == (1, 1, 1)


@pytest.mark.parametrize("cells", [((0, 0), (0, 0)), ((0, 0), (1, 0), (1, 1)), ((-3, 0), (-2, 0))])
def test_who_never_leaves_and_who_never_arrives_has_no_trip(walked, cells):
    found = path_efficiency.measure(walked(*cells))
    assert found["n_trips"] == 0
    assert math.isnan(found["trip_efficiency"])
    assert math.isnan(found["trip_efficiency_moving"])
