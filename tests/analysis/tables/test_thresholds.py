"""From which value of a setting an outcome prevails."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.tables.comparison import Comparison, compare
from analysis.tables.groups import swept_columns
from analysis.tables.thresholds import passed, risen, sentences, thresholds, thresholds_table
from signature_tables import runs, table

SHARES = (0.0, 0.1, 0.2, 0.3)
SETTING = "world.committed"


def compared(shares: tuple[float, ...] = SHARES, **turned: tuple[int, ...]) -> Comparison:
    """Return ten seeds of each share, as many of them turned as is said of each model."""
    rows = [
        run
        for model, counts in turned.items()
        for share, count in zip(shares, counts, strict=True)
        for run in runs(model, [1.0] * count + [0.0] * (10 - count), "naming.turned", **{SETTING: share})
    ]
    made = table(rows, (SETTING,))
    return compare(made, swept_columns(made))


def test_the_threshold_of_each_model_stands_between_the_values_that_are_sure():
    frame = thresholds(compared(early=(0, 10, 10, 10), late=(0, 0, 4, 10)))
    early, late = frame.to_dict("records")
    assert (early["setting"], early["model"], early["values"], early["n"]) == ("world.committed", "early", 4, 10)
    assert (early["threshold"], early["low"], early["high"]) == pytest.approx((0.05, 0, 0.1))
    assert (late["threshold"], late["low"], late["high"]) == pytest.approx((0.2 + 0.1 / 6, 0.1, 0.3))
    (first, _) = thresholds_table(frame).rows
    assert first[1:] == ("world.committed", "early", "4", "10", "0.050 [0.000, 0.100]", "from")


def test_a_model_without_a_threshold_or_with_an_unsure_end_is_told_so():
    always, never = thresholds(compared(always=(10, 10, 10, 10), never=(0, 0, 1, 5))).to_dict("records")
    assert (always["prevails"], never["prevails"]) == ("always", "never")
    assert math.isnan(always["threshold"]) and math.isnan(never["threshold"])
    (said,) = sentences(thresholds(compared(few=(3, 4, 6, 7))))
    assert "prevails from world.committed = 0.15; no value is surely beyond the lower and upper end" in said
    assert thresholds(compared(none=(0, 0, 0, 0))).empty
    assert thresholds(compared((0.0, 0.1), two=(0, 10))).empty


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12))
def test_risen_shares_never_fall_keep_their_mean_and_leave_rising_ones_alone(shares: list[float]):
    found = risen(np.array(shares), np.ones(len(shares)))
    assert (np.diff(found) >= -1e-12).all() and found.mean() == pytest.approx(np.mean(shares))
    np.testing.assert_allclose(risen(np.sort(shares), np.ones(len(shares))), np.sort(shares))


def test_where_one_half_is_passed_is_read_on_the_line_between_two_values():
    assert passed(np.array([0, 1, 3]), np.array([0.0, 0.25, 0.75])) == pytest.approx(2)
    assert math.isnan(passed(np.array([0, 1]), np.array([0.6, 0.9])))
