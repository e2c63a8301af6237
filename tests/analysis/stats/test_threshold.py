"""Where an outcome begins to prevail: bisection against a known threshold, and what is sure of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.stats.threshold import Search, next_value, threshold

USUAL = Search(low=0, high=0.7, until=0.02, level=0.5)


def searched(turning: float, search: Search = USUAL, runs: int = 10) -> dict[float, np.ndarray]:
    """Return what is played where the outcome prevails in all runs from a value on."""
    points: dict[float, np.ndarray] = {}
    while (value := next_value(search, points)) is not None:
        assert value not in points
        points[value] = np.full(runs, float(value >= turning))
    return points


@given(st.floats(0.001, 0.699))
def test_the_bracket_holds_the_threshold_and_is_as_narrow_as_asked(turning: float):
    points = searched(turning)
    found = threshold(USUAL, points)
    assert found.low < turning <= found.high and found.high - found.low <= 0.02
    assert found.at == pytest.approx((found.low + found.high) / 2) and len(points) == 8
    assert (found.surely_low, found.surely_high) == (found.low, found.high)


@given(st.integers(1, 400), st.data())
def test_a_share_of_so_many_is_looked_for_in_whole_counts_down_to_neighbours(of: int, data: st.DataObject):
    turning = data.draw(st.integers(1, of))
    search = Search(low=0, high=1, until=1e-9, level=0.5, of=of)
    points = searched((turning - 0.5) / of, search)
    found = threshold(search, points)
    assert (found.low, found.high) == ((turning - 1) / of, turning / of)
    assert all(value * of == pytest.approx(round(value * of)) for value in points)


@pytest.mark.parametrize(("turning", "low", "high"), [(-1, math.nan, 0), (9, 0.7, math.nan)])
def test_a_threshold_beyond_the_ends_is_none_and_costs_two_values(turning: float, low: float, high: float):
    points = searched(turning)
    found = threshold(USUAL, points)
    assert set(points) == {0, 0.7} and math.isnan(found.at)
    np.testing.assert_array_equal((found.low, found.high), (low, high))


def test_a_value_at_which_half_of_an_even_number_of_runs_prevail_is_the_threshold():
    points = {0.0: np.zeros(10), 1.0: np.ones(10), 0.5: np.array([1.0, 0.0] * 5)}
    search = Search(low=0, high=1, until=0.01, level=0.5)
    assert next_value(search, points) is None
    found = threshold(search, points)
    assert (found.low, found.at, found.high) == (0.5, 0.5, 0.5)


def test_a_value_that_chance_may_have_put_on_its_side_is_not_sure():
    points = {0.0: np.zeros(10), 1.0: np.ones(10), 0.5: np.array([1.0] * 6 + [0.0] * 4)}
    found = threshold(Search(low=0, high=1, until=0.5, level=0.5), points)
    assert (found.low, found.high) == (0, 0.5) and (found.surely_low, found.surely_high) == (0, 1)
