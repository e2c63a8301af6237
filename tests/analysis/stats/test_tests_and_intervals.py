"""Sign flips, bootstrap-t, spreads: against libraries and by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from analysis.stats.intervals import RESAMPLES, bootstrap_t, estimate, estimates
from analysis.stats.sign_flip import assignments, fewest_pairs, least_p, sign_flip_interval, sign_flip_p
from foundry import seeding


def random(n: int, rows: int = 1) -> np.ndarray:
    return np.random.default_rng(n).normal(0.4, 1.0, size=(rows, n))


@pytest.mark.parametrize("n", [6, 9, 12])
def test_exact_sign_flips_equal_the_library(n: int):
    rows = np.vstack([random(n), np.round(random(n)), np.full((1, n), 0.1)])
    expected = [
        stats.permutation_test((row,), np.mean, permutation_type="samples", n_resamples=np.inf).pvalue for row in rows
    ]
    assert sign_flip_p(rows).tolist() == pytest.approx(expected, abs=1e-12)


def test_drawn_sign_flips_are_near_the_exact_ones_and_always_the_same():
    rows = random(18, rows=3)
    signs = 1.0 - 2.0 * (np.arange(2**18)[:, None] >> np.arange(18) & 1)
    exact = (np.abs(rows @ signs.T) >= np.abs(rows.sum(axis=1))[:, None] - 1e-9).mean(axis=1)
    assert sign_flip_p(rows) == pytest.approx(exact, abs=0.015)
    assert (sign_flip_p(rows) == sign_flip_p(rows)).all()
    assert sign_flip_p(np.ones((1, 40)))[0] == pytest.approx(least_p(40)) == 1e-4


@pytest.mark.parametrize("n", [6, 10, 18])
def test_the_interval_holds_the_shifts_that_the_test_does_not_reject(n: int):
    rows = np.vstack([random(n, rows=3), np.round(random(n), 1)])
    for side, ends in zip((-1, 1), sign_flip_interval(rows), strict=True):
        inside, beyond = (rows - (ends + side * step)[:, None] for step in (-1e-6, 1e-6))
        assert (sign_flip_p(inside) > 0.05).all() and (sign_flip_p(beyond) <= 0.05).all()


def test_a_row_has_the_same_p_whatever_other_rows_there_are_over_assignments_that_differ():
    rows = random(17, rows=150)
    assert sign_flip_p(rows)[149] == sign_flip_p(rows[149:])[0]
    assert len(np.unique(assignments(8), axis=0)) == 2**7


@pytest.mark.parametrize(("level", "fewest"), [(0.05, 6), (0.05 / 12, 9), (0.05 / 36, 11), (1e-6, None)])
def test_how_many_pairs_an_exact_test_needs(level: float, fewest: int | None):
    assert fewest_pairs(level) == fewest


@given(st.integers(0, 10**6), st.sampled_from([6, 9, 10, 11, 30]), st.sampled_from([-1, 1]), st.floats(0.1, 1))
def test_skewed_values_get_an_interval_as_wide_as_students_and_as_the_bootstrap_t(
    seed: int, n: int, side: int, width: float
):
    values = side * np.random.default_rng(seed).lognormal(sigma=width, size=n)
    found, student = estimate(values), stats.ttest_1samp(values, 0).confidence_interval()
    skewed = n >= 10 and abs(stats.skew(values)) > 0.5
    ends = [end[0] for end in bootstrap_t(values[None, :])] if skewed else student
    assert (found.interval, found.note) == ("bootstrap-t" if skewed else "t", "")
    assert (found.low, found.high) == pytest.approx((min(student.low, ends[0]), max(student.high, ends[1])))


@pytest.mark.parametrize(("values", "note"), [
    ([], "no value"),
    ([0.3], "one value"),
    ([0.3, 0.4, 0.5, 0.6, 0.7], "descriptive (n < 6)"),
    ([-3e8, -1e8 * (0.1 + 0.2) * 10], "no variation; descriptive (n < 6)"),
    ([0.3] * 6, "no variation"),
])  # fmt: skip
def test_what_keeps_an_interval_from_being_one_is_noted(values: list[float], note: str):
    assert estimate(np.array(values)).note == note


def test_the_bootstrap_t_is_that_of_the_textbook_and_leans_to_the_long_tail():
    values = random(11)[0] ** 2
    rng = np.random.default_rng(5)
    drawn = values[rng.integers(0, 11, size=(40_000, 11))]
    t = (drawn.mean(axis=1) - values.mean()) / (drawn.std(axis=1, ddof=1) / math.sqrt(11))
    error = values.std(ddof=1) / math.sqrt(11)
    expected = values.mean() - np.quantile(t, [0.975, 0.025]) * error
    low, high = bootstrap_t(values[None, :])
    assert [low[0], high[0]] == pytest.approx(expected.tolist(), abs=0.1)
    assert RESAMPLES == 1_999
    skewed = np.random.default_rng(0).lognormal(size=(1, 12))
    low, high = bootstrap_t(skewed)
    assert high[0] - skewed.mean() > 1.5 * (skewed.mean() - low[0])


@pytest.mark.parametrize("n", [10, 12, 15])
def test_the_ends_of_the_bootstrap_t_are_the_order_statistics_that_are_documented(n: int):
    values = np.random.default_rng(n).lognormal(size=n)
    drawn = values[seeding.stream(n, "bootstrap-t").integers(0, n, size=(1_999, n))]
    t = np.sort((drawn.mean(axis=1) - values.mean()) * math.sqrt(n) / drawn.std(axis=1, ddof=1))
    error = values.std(ddof=1) / math.sqrt(n)
    low, high = bootstrap_t(values[None, :])
    assert [low[0], high[0]] == pytest.approx([values.mean() - t[rank - 1] * error for rank in (1_950, 50)], abs=1e-9)
    assert np.diff(t[[48, 49, 50, 1_948, 1_949, 1_950]]).min() > 1e-6, "the next ones are others"


def test_where_resamples_have_no_spread_the_interval_stays_finite():
    found = estimate(np.array([0.0] * 9 + [1.0]), 0.0, 1.0)
    assert found.interval == "t"
    assert (found.low, found.high) == (0.0, pytest.approx(0.1 + 2.262157 * 0.1, abs=1e-6))


def test_outcomes_get_wilsons_interval_even_when_all_are_the_same():
    found = estimates(np.ones((1, 10)), np.zeros(1), np.ones(1), binary=np.array([True])).row(0)
    assert (found.interval, found.note, found.high) == ("wilson", "", pytest.approx(1.0))
    assert found.low == pytest.approx(stats.binomtest(10, 10).proportion_ci(method="wilson").low)


def test_rows_with_gaps_and_very_many_rows_are_estimated_as_if_alone():
    rows = random(8, rows=4)
    rows[1, 3], rows[2, :6], rows[3] = math.nan, math.nan, math.nan
    found = estimates(rows, np.full(4, -math.inf), np.full(4, math.inf))
    for index, row in enumerate(rows):
        assert repr(found.row(index)) == repr(estimate(row))
    rows = np.random.default_rng(0).lognormal(size=(600, 12))
    found = estimates(rows, np.full(600, -math.inf), np.full(600, math.inf))
    for index in (0, 255, 256, 511, 512, 599):
        alone = estimate(rows[index])
        assert (found.low[index], found.high[index]) == pytest.approx((alone.low, alone.high))
