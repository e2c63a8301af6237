"""Outcomes of which each run has one, against equal chances."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from analysis.stats.intervals import Estimate
from analysis.tables.comparison import Comparison
from analysis.tables.equal_chances import equal_chances, equal_chances_table, uniform_p
from foundry import seeding

NAMES = ("ama", "bodo", "ceri")
NONE = Estimate(n=0, mean=np.nan, sd=np.nan, low=np.nan, high=np.nan, interval="", note="")


def compared(**won: str) -> Comparison:
    """Return groups with the winner of each seed, by its first letter; - for none."""
    values = {
        (model,): pd.DataFrame(
            [
                {f"naming.won_{name}": np.nan if one == "-" else float(one == name[0]) for name in NAMES}
                for one in winners
            ]
        )
        for model, winners in won.items()
    }
    estimates = {(f"naming.won_{name}", group): NONE for name in NAMES for group in values}
    return Comparison(pd.DataFrame(), ("model",), values, estimates)


@pytest.mark.parametrize(
    ("counts", "statistic", "p"),
    [
        ([2, 0], 2, 1 / 2),
        ([1, 1], 0, 1),
        ([3, 0, 0], 6, 3 / 27),
        ([2, 1, 0], 2, 21 / 27),
        ([0, 0, 0, 5], 15, 4 / 4**5),
    ],
)
def test_the_chance_of_counts_is_that_of_the_multinomial_worked_by_hand(counts: list[int], statistic: float, p: float):
    found = uniform_p(np.array(counts, dtype=float))
    assert found[0] == pytest.approx(statistic) and abs(found[1] - p) < 0.012


def test_equal_chances_are_told_from_equal_ones_as_often_as_the_level_says():
    drawn = seeding.stream(7, "test").multinomial(12, np.full(4, 1 / 4), size=100)
    told = sum(uniform_p(one.astype(float))[1] <= 0.1 for one in drawn)
    assert 2 <= told <= 18, "at most a tenth, less what is lost to whole counts"


def test_seeds_are_counted_by_group_without_those_that_have_no_outcome_or_row():
    first, second = equal_chances(compared(a="aab-", b="cccccc", c="--")).to_dict("records")
    assert (first["model"], first["n"], first["outcomes"], first["most"]) == ("a", 3, 3, "ama")
    assert first["share"] == pytest.approx(2 / 3) and first["counts"] == "ama 2, bodo 1"
    assert (second["model"], second["counts"], second["chi_square"]) == ("b", "ceri 6", 12) and second["p"] < 0.02
    found = compared(a="aab", b="ccc")
    estimates = {key: one for key, one in found.estimates.items() if key[1] == ("b",)}
    frame = equal_chances(Comparison(pd.DataFrame(), ("model",), found.values, estimates))
    assert frame["model"].tolist() == ["b"]
    (row,) = equal_chances_table(frame).rows
    assert row[:4] == ("naming.won_*", "b", "ceri 3", "3")
