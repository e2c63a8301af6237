"""Means and intervals of groups, outcomes against equal chances, and from which value on an outcome prevails."""

import math

import numpy as np
import pandas as pd
import pytest

from analysis.stats.intervals import Estimate
from analysis.tables.comparison import Comparison, compare
from analysis.tables.equal_chances import equal_chances, equal_chances_table, uniform_p
from analysis.tables.groups import swept_columns
from analysis.tables.thresholds import passed, sentences, thresholds, thresholds_table
from signature_tables import runs, table


def groups_of(rows: list[dict[str, object]]):
    made = table(rows)
    return compare(made, made.frame[["model"]].astype(str))


def row(comparison, group: str) -> pd.Series:
    return comparison.frame[comparison.frame["model"] == group].iloc[0]


def test_repeats_of_a_seed_count_once_and_missing_values_are_counted():
    column = row(groups_of([*runs("a", [0.1, 0.2]), *runs("a", [0.3, 0.4])]), "a")
    assert (column["runs"], column["n"]) == (4, 2)
    assert column["mean"] == pytest.approx(0.25)
    column = row(groups_of(runs("a", [0.1, math.nan, 0.3])), "a")
    assert (column["runs"], column["n"], column["mean"]) == (3, 2, pytest.approx(0.2))


def test_groups_and_baselines_are_described_by_the_measures_their_runs_have():
    made = groups_of([*runs("a", [0.1, 0.2], "idle_rate.chosen"), *runs("b", [0.5, 0.7], "turning.rate")])
    assert made.frame[["measure", "model"]].to_numpy().tolist() == [["idle_rate.chosen", "a"], ["turning.rate", "b"]]
    made = groups_of([*runs("a", [0.1, 0.2], baseline=False), *runs("walker", [0.5, 0.5], baseline=True)])
    assert made.frame["baseline"].tolist() == [False, True]
    assert made.baselines == {("walker",)}
    made = groups_of([*runs("a", [1] * 8 + [0] * 2, "path_efficiency.success")])
    assert (made.frame["low"][0], made.frame["interval"][0]) == (pytest.approx(0.490162, abs=1e-6), "wilson")


NAMES = ("ama", "bodo", "ceri")
NO_VALUE = Estimate(n=0, mean=np.nan, sd=np.nan, low=np.nan, high=np.nan, interval="", note="")


def winners_of(**won: str) -> Comparison:
    """Return groups with the winner of each seed, by its first letter; - for none."""
    values = {
        (model,): pd.DataFrame(
            [
                {f"naming.won_{name}": np.nan if winner == "-" else float(winner == name[0]) for name in NAMES}
                for winner in winners
            ]
        )
        for model, winners in won.items()
    }
    estimates = {(f"naming.won_{name}", group): NO_VALUE for name in NAMES for group in values}
    return Comparison(pd.DataFrame(), ("model",), values, estimates)


@pytest.mark.parametrize(
    ("counts", "statistic", "p"),
    [([1, 1], 0, 1), ([3, 0, 0], 6, 3 / 27), ([2, 1, 0], 2, 21 / 27), ([0, 0, 0, 5], 15, 4 / 4**5)],
)
def test_the_chance_of_counts_is_that_of_the_multinomial_worked_by_hand(counts: list[int], statistic: float, p: float):
    found = uniform_p(np.array(counts, dtype=float))
    assert found[0] == pytest.approx(statistic) and abs(found[1] - p) < 0.012


def test_seeds_are_counted_by_group_without_those_that_have_no_outcome_or_row():
    first, second = equal_chances(winners_of(a="aab-", b="cccccc", c="--")).to_dict("records")
    assert (first["model"], first["n"], first["outcomes"], first["most"]) == ("a", 3, 3, "ama")
    assert first["share"] == pytest.approx(2 / 3) and first["counts"] == "ama 2, bodo 1"
    assert (second["model"], second["counts"], second["chi_square"]) == ("b", "ceri 6", 12) and second["p"] < 0.02
    comparison = winners_of(a="aab", b="ccc")
    estimates = {key: estimate for key, estimate in comparison.estimates.items() if key[1] == ("b",)}
    frame = equal_chances(Comparison(pd.DataFrame(), ("model",), comparison.values, estimates))
    assert frame["model"].tolist() == ["b"]
    (row,) = equal_chances_table(frame).rows
    assert row[:4] == ("naming.won_*", "b", "ceri 3", "3")


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
    (uneven,) = thresholds(compared(uneven=(0, 8, 4, 10))).to_dict("records")
    assert uneven["threshold"] == pytest.approx(0.1 * 0.5 / 0.6), "the falling shares 0.8 and 0.4 count as 0.6 each"
    (first, _) = thresholds_table(frame).rows
    assert first[1:] == ("world.committed", "early", "4", "10", "0.050 [0.000, 0.100]", "from")


def test_a_model_without_a_threshold_or_with_an_unsure_end_is_told_so():
    always, never = thresholds(compared(always=(10, 10, 10, 10), never=(0, 0, 1, 5))).to_dict("records")
    assert (always["prevails"], never["prevails"]) == ("always", "never")
    assert math.isnan(always["threshold"]) and math.isnan(never["threshold"])
    (said,) = sentences(thresholds(compared(few=(3, 4, 6, 7))))
    assert "prevails from world.committed = 0.15; no value is clearly beyond the lower and upper end" in said
    assert thresholds(compared(none=(0, 0, 0, 0))).empty
    assert thresholds(compared((0.0, 0.1), two=(0, 10))).empty


@pytest.mark.parametrize("counts", [(10, 10, 2, 0), (10, 10, 10, 0), (0, 10, 10, 0)])
def test_an_outcome_that_stops_again_prevails_at_some_values_only(counts):
    frame = thresholds(compared(falling=counts))
    assert frame["prevails"].tolist() == ["some"]
    assert math.isnan(frame["threshold"][0])
    (said,) = sentences(frame)
    assert "prevails at some values of world.committed, but at no threshold does it begin to prevail for good" in said


def test_where_one_half_is_passed_is_read_on_the_line_between_two_values():
    assert passed(np.array([0, 1, 3]), np.array([0.0, 0.25, 0.75])) == pytest.approx(2)
    assert math.isnan(passed(np.array([0, 1]), np.array([0.6, 0.9])))
