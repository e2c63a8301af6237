"""Means, intervals, paired differences."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from analysis.comparison import compare, headline
from analysis.intervals import estimate
from analysis.table import KEYS, SignatureTable


def table(rows: list[dict[str, object]]) -> SignatureTable:
    """Return a table of runs given by model, seed and values."""
    filled = [{"run": n, "world": "w", "prompt": "p", "status": "complete", **row} for n, row in enumerate(rows)]
    measures = tuple(key for key in rows[0] if "." in key)
    return SignatureTable(pd.DataFrame(filled)[[*KEYS, *measures]], (), measures, (frozenset(measures),) * len(rows))


def compared(rows: list[dict[str, object]], by: tuple[str, ...] = ("model",)):
    made = table(rows)
    return compare(made, made.frame[list(by)].astype(str))


def runs(model: str, values: list[float], **more: object) -> list[dict[str, object]]:
    return [{"model": model, "seed": seed, "idle_rate.chosen": value, **more} for seed, value in enumerate(values)]


def row(comparison, group: str) -> pd.Series:
    return comparison.frame[comparison.frame["model"] == group].iloc[0]


def test_the_interval_is_students():
    values = np.array([0.1, 0.4, 0.35, 0.8, 0.2, 0.25])
    found = estimate(values)
    expected = stats.ttest_1samp(values, 0).confidence_interval()
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), abs=1e-12)
    assert (found.n, found.note) == (6, "")


def test_the_interval_is_clipped_to_what_is_possible():
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


def test_differences_are_paired_by_seed():
    first, second = [0.1, 0.5, 0.3, 0.2, 0.9, 0.4], [0.2, 0.7, 0.3, 0.6, 0.9, 0.8]
    found = row(compared([*runs("a", first), *runs("b", second)]), "b")
    expected = stats.ttest_rel(second, first).confidence_interval()
    assert (found["reference"], found["n_pairs"]) == ("a", 6)
    assert found["difference"] == pytest.approx(np.mean(np.subtract(second, first)))
    assert (found["difference_low"], found["difference_high"]) == pytest.approx((expected.low, expected.high))


def test_incomplete_pairs_are_left_out_and_counted():
    found = row(compared([*runs("a", [0.1, math.nan, 0.3]), *runs("b", [0.2, 0.9, 0.5, 0.7])]), "b")
    assert (found["n"], found["n_pairs"]) == (4, 2)
    assert found["difference"] == pytest.approx(0.15)
    assert found["difference_note"] == "descriptive (n < 6)"


def test_the_first_model_is_compared_with_nothing():
    found = row(compared([*runs("a", [0.1, 0.2]), *runs("b", [0.2, 0.9])]), "a")
    assert (found["reference"], found["n_pairs"]) == ("", 0)
    assert math.isnan(found["difference"])


def test_a_constant_difference_has_no_interval():
    found = row(compared([*runs("a", [0.1, 0.2, 0.3]), *runs("b", [0.2, 0.3, 0.4])]), "b")
    assert found["difference"] == pytest.approx(0.1)
    assert math.isnan(found["difference_low"])
    assert found["difference_note"].startswith("no variation")


def test_repeats_of_a_seed_count_once():
    found = row(compared([*runs("a", [0.1, 0.2]), *runs("a", [0.3, 0.4])]), "a")
    assert (found["runs"], found["n"]) == (4, 2)
    assert found["mean"] == pytest.approx(0.25)


def test_models_are_compared_within_the_same_prompt():
    rows = [run for p in ("x", "y") for m in ("a", "b") for run in runs(m, [0.1, 0.2 if m == "a" else 0.4], prompt=p)]
    frame = compared(rows, ("model", "prompt")).frame
    assert frame["reference"].tolist() == ["", "a / x", "", "a / y"]


def test_with_one_model_prompts_are_compared():
    rows = [run for prompt in ("x", "y") for run in runs("a", [0.1, 0.2], prompt=prompt)]
    assert compared(rows, ("model", "prompt")).frame["reference"].tolist() == ["", "a / x"]


def test_worlds_are_never_compared_with_one_another():
    rows = [run for world in ("v", "w") for run in runs("a", [0.1, 0.2], world=world)]
    assert compared(rows, ("model", "world")).frame["reference"].tolist() == ["", ""]


def test_the_headline_has_a_column_per_group():
    found = headline(compared([*runs("a", [0.1, 0.2]), *runs("b", [0.5, 0.5])]))
    assert found.columns == ("measure", "a", "b")
    assert found.rows == (("idle_rate.chosen", "0.15 [0, 0.785]", "0.5"),)


def test_many_groups_stand_below_one_another():
    rows = [run for model in "abcdef" for run in runs(model, [math.nan])]
    found = headline(compared(rows))
    assert found.columns == ("measure", "group", "mean [95 % interval]")
    assert found.rows[0] == ("idle_rate.chosen", "a", "-")
    assert len(found.rows) == 6
