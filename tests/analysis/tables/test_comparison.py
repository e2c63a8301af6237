"""Means and intervals of groups."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from analysis.stats.intervals import estimate
from analysis.tables.comparison import compare
from signature_tables import runs, table


def compared(rows: list[dict[str, object]], by: tuple[str, ...] = ("model",)):
    made = table(rows)
    return compare(made, made.frame[list(by)].astype(str))


def row(comparison, group: str) -> pd.Series:
    return comparison.frame[comparison.frame["model"] == group].iloc[0]


def test_the_interval_is_students_within_what_is_possible():
    values = np.array([0.1, 0.4, 0.35, 0.8, 0.2, 0.25])
    found = estimate(values)
    expected = stats.ttest_1samp(values, 0).confidence_interval()
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), abs=1e-12)
    assert (found.n, found.note) == (6, "")
    found = estimate(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.3]), 0.0, 1.0)
    assert found.low == 0.0
    assert found.high < 1.0


@pytest.mark.parametrize(
    ("values", "n", "note"),
    [
        ([], 0, "no value"),
        ([math.nan], 0, "no value"),
        ([0.5, math.nan], 1, "one value"),
        ([0.3] * 7, 7, "no variation"),
        ([0.1 + 0.2, 0.3], 2, "no variation; descriptive (n < 6)"),
        ([0.1, 0.2], 2, "descriptive (n < 6)"),
    ],
)
def test_what_keeps_a_number_from_being_a_claim_is_said(values, n, note):
    found = estimate(np.array(values))
    assert (found.n, found.note) == (n, note)
    assert math.isnan(found.low) == (note not in ("descriptive (n < 6)",))


def test_repeats_of_a_seed_count_once_and_missing_values_are_counted():
    found = row(compared([*runs("a", [0.1, 0.2]), *runs("a", [0.3, 0.4])]), "a")
    assert (found["runs"], found["n"]) == (4, 2)
    assert found["mean"] == pytest.approx(0.25)
    found = row(compared(runs("a", [0.1, math.nan, 0.3])), "a")
    assert (found["runs"], found["n"], found["mean"]) == (3, 2, pytest.approx(0.2))


def test_groups_and_baselines_are_described_by_the_measures_their_runs_have():
    made = compared([*runs("a", [0.1, 0.2], "idle_rate.chosen"), *runs("b", [0.5, 0.7], "turning.rate")])
    assert made.frame[["measure", "model"]].to_numpy().tolist() == [["idle_rate.chosen", "a"], ["turning.rate", "b"]]
    made = compared([*runs("a", [0.1, 0.2], baseline=False), *runs("walker", [0.5, 0.5], baseline=True)])
    assert made.frame["baseline"].tolist() == [False, True]
    assert made.baselines == {("walker",)}
    made = compared([*runs("a", [1] * 8 + [0] * 2, "path_efficiency.success")])
    assert (made.frame["low"][0], made.frame["interval"][0]) == (pytest.approx(0.490162, abs=1e-6), "wilson")
