"""The table of differences."""

import math

import numpy as np
import pandas as pd
import pytest

from analysis.stats.contrasts import COLUMNS, contrasts
from analysis.stats.max_t import over_pairs, step_down_p
from foundry.errors import InputError
from signature_tables import MEASURE, runs, table, table_of

FIRST, SECOND = [0.1, 0.5, 0.3, 0.2, 0.9, 0.4], [0.2, 0.7, 0.3, 0.6, 0.9, 0.8]


def only(rows: list[dict[str, object]], **more) -> pd.Series:
    frame = contrasts(table(rows), **more)
    assert len(frame) == 1
    return frame.iloc[0]


def test_differences_are_paired_by_seed_within_the_possible_range():
    column = only([*runs("a", FIRST), *runs("b", SECOND)])
    differences = np.subtract(SECOND, FIRST)
    assert (column["level"], column["reference"], column["factor"], column["context"]) == ("b", "a", "model", "")
    assert column["difference"] == pytest.approx(differences.mean())
    assert (column["low"], column["high"]) == pytest.approx((differences.min(), differences.max()))
    assert (column["interval"], column["test"], column["n_pairs"]) == ("sign-flip", "sign-flip", 6)
    assert (column["mean_level"], column["mean_reference"]) == pytest.approx((np.mean(SECOND), np.mean(FIRST)))
    assert column["superiority"] == pytest.approx(4 / 6 + 1 / 6)
    assert column["p"] == pytest.approx(2 / 16)
    column = only([*runs("a", [0.1] * 6), *runs("a", [0.3] * 6), *runs("b", SECOND)])
    assert (column["n_pairs"], column["mean_reference"]) == (6, pytest.approx(0.2)), "repeats of a seed count once"
    column = only([*runs("a", [0, 0, 0, 0, 0, 1.0]), *runs("b", [1, 1, 1, 1, 1, 0.9])])
    assert column["high"] == 1.0, "differences cannot leave the possible range"


def test_rows_of_a_server_that_does_not_repeat_itself_say_so_and_no_others():
    frame = contrasts(
        table([*runs("a", FIRST), *runs("b", SECOND), *runs("c", FIRST)]), repeating={"b": "b repeats 8 of 10"}
    )
    said = frame.set_index(["level", "reference"])["note"].str.contains("b repeats 8 of 10")
    assert said.to_dict() == {("b", "a"): True, ("c", "a"): False, ("c", "b"): True}


def test_a_missing_run_a_seed_never_asked_and_an_undefined_measure_are_told_apart():
    first = runs("a", [0.1, math.nan, 0.3, 0.2, 0.5, 0.4, 0.1, 0.3])
    first[1]["status"] = "failed"
    second = runs("b", [0.2, 0.9, math.nan, 0.7, 0.6, 0.8, 0.9, 0.7])
    column = only([*first, *second])
    assert (column["n_pairs"], column["n_missing"], column["n_undefined"]) == (6, 1, 1)
    assert column["mean_level"] - column["mean_reference"] == pytest.approx(column["difference"])
    assert column["note"] == "missing in 1 of 8 seeds; undefined in 1 of 8 seeds"
    known = column["difference"] * 6
    assert column["bound_low"] == pytest.approx((known + 0.9 - 1) / 7)
    assert column["bound_high"] == pytest.approx((known + 0.9 - 0) / 7)
    column = only([*runs("a", FIRST), *runs("b", [*SECOND, 0.5])])
    assert (column["n_pairs"], column["n_missing"]) == (6, 1)
    assert not math.isnan(column["bound_low"])
    missing = [*runs("a", FIRST, "path.made_up"), *runs("b", SECOND[:5], "path.made_up")]
    assert math.isnan(only(missing)["bound_low"])


@pytest.mark.parametrize(
    ("first", "second", "why"),
    [
        ([0.1] * 5, [0.2, 0.3, 0.4, 0.5, 0.6], "n < 6"),
        ([0.3] * 6, [0.3] * 6, "no difference in any seed"),
        ([0.1 + 0.2] * 6, [0.3] * 6, "no difference in any seed"),
        ([math.nan] * 6, [0.5] * 6, "no pair"),
    ],
)
def test_what_cannot_be_tested_has_no_p_and_says_why(first, second, why):
    column = only([*runs("a", first), *runs("b", second)])
    assert column["test"] == f"not tested: {why}"
    assert math.isnan(column["p"])
    assert not column["significant"]


@pytest.mark.parametrize("n", [6, 10, 17])
def test_an_interval_holds_0_exactly_where_its_test_finds_nothing(n: int):
    rng, shape = np.random.default_rng(n), (n, 60)
    values = [
        rng.normal(0.5, size=shape), np.round(rng.normal(0.5, size=shape), 1),
        rng.integers(-1, 4, size=shape) / 10, rng.choice([-1.0, 0.0, 1.0], size=shape, p=[0.1, 0.4, 0.5]),
        np.where(rng.random(shape) < 0.5, 0, rng.lognormal(size=shape)),
    ]  # fmt: skip
    second = np.concatenate(values, axis=1)
    rows = contrasts(table_of(np.stack([0 * second, second]), [f"x.m{index}" for index in range(300)]))
    rows = rows[rows["interval"] == "sign-flip"]
    excluded = (rows["low"] > 0) | (rows["high"] < 0)
    assert len(rows) > 250 and 0 < excluded.sum() < len(rows)
    assert excluded.equals(rows["p"] <= 0.05)


def test_five_pairs_have_students_interval_and_equal_differences_none_and_are_tested():
    few = only([*runs("a", FIRST[:5]), *runs("b", SECOND[:5])])
    equal = only([*runs("a", [0.1] * 6), *runs("b", [0.3] * 6)])
    assert (few["interval"], few["note"]) == ("t", "descriptive (n < 6)")
    assert (equal["interval"], equal["p"], equal["note"]) == ("", 2 / 2**6, "no variation")
    column = only([*runs("a", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), *runs("b", [0.2, 0.3, 0.4, 0.5, 0.6, 0.7])])
    assert (column["test"], column["p"], column["significant"]) == ("sign-flip", 2 / 2**6, True)


def test_outcomes_are_tested_as_mcnemars_exact_test_does_unless_they_are_equal_in_every_seed():
    measure = "path_efficiency.success"
    column = only([*runs("a", [0] * 7 + [1] * 3, measure), *runs("b", [1] * 6 + [0, 1, 1, 1], measure)])
    assert (column["test"], column["p"]) == ("sign-flip", pytest.approx(0.03125))
    column = only([*runs("a", [0] * 6, measure), *runs("b", [1] * 6, measure)])
    assert (column["test"], column["p"]) == ("sign-flip", pytest.approx(0.03125))
    assert (column["difference"], column["significant"]) == (1, True)
    column = only([*runs("a", [0, 1] * 3, measure), *runs("b", [0, 1] * 3, measure)])
    assert column["test"] == "not tested: no difference in any seed"


def test_every_pair_of_levels_is_compared_within_the_same_context():
    rows = [run for p in ("x", "y") for m in ("a", "b", "c") for run in runs(m, FIRST, prompt=p)]
    frame = contrasts(table(rows))
    models = frame[frame["factor"] == "model"]
    assert list(zip(models["level"], models["reference"], models["context"], strict=True)) == [
        (*pair, f"prompt={p}") for p in ("x", "y") for pair in (("b", "a"), ("c", "a"), ("c", "b"))
    ]
    prompts = frame[frame["factor"] == "prompt"]
    assert prompts["context"].tolist() == ["model=a", "model=b", "model=c"]


def test_any_swept_setting_or_column_is_a_factor_and_worlds_are_compared_by_what_they_share():
    arms = [{"world.steps": steps, "sampling_seed": repeat} for steps in (20, 40) for repeat in (0, 1)]
    rows = [{**run, **arm} for arm in arms for run in runs("a", FIRST)]
    frame = contrasts(table(rows, ("world.steps", "sampling_seed")))
    assert frame[["factor", "level", "reference"]].to_numpy().tolist() == [["world.steps", "40", "20"]]
    shared, own = "outcome.readable", "idle_rate.chosen"
    rows = [{**run, own: 0.1} for run in runs("a", FIRST, shared, world="v")] + runs("a", SECOND, shared, world="w")
    frame = contrasts(table(rows))
    assert frame[["factor", "measure"]].to_numpy().tolist() == [["world", shared]]
    rows = [{**run, "baseline": False} for prompt in ("x", "y") for run in runs("a", FIRST, prompt=prompt)]
    made = table(rows)
    frame = contrasts(made, made.frame[["prompt"]])
    assert frame[["factor", "level", "reference", "context"]].to_numpy().tolist() == [["prompt", "y", "x", ""]]
    frame = contrasts(table(runs("a", FIRST)))
    assert frame.empty
    assert list(frame.columns) == list(COLUMNS)


def test_the_family_is_the_headline_of_one_factor_over_all_decisions():
    measures = ["idle_rate.chosen", "idle_rate.chosen_readable", "idle_rate.n_decisions", "failure.rate", "cost.calls"]
    values = np.random.default_rng(0).random((3, 8, len(measures)))
    frame = contrasts(table_of(values, measures))
    assert frame[frame["headline"]]["measure"].unique().tolist() == ["idle_rate.chosen"]
    assert frame[frame["headline"]]["family"].tolist() == [3, 3, 3]
    assert frame[frame["readable_only"]]["measure"].unique().tolist() == ["idle_rate.chosen_readable"]
    beside = frame[~frame["headline"]]
    assert beside["p_adjusted"].isna().all() and beside["p"].notna().all()
    assert set(frame["measure"][frame["p_bh"].notna()]) == {"idle_rate.chosen", "failure.rate", "cost.calls"}


def test_tests_are_corrected_over_the_measures_of_a_pair_and_over_the_pairs():
    rng = np.random.default_rng(1)
    measures = ["x.one", "x.two"]
    values = rng.normal(size=(3, 20, 2)) + np.array([0, 0.5, 1])[:, None, None]
    frame = contrasts(table_of(values, measures), family=measures)
    differences = [values[second] - values[first] for first, second in ((0, 1), (0, 2), (1, 2))]
    inside = np.concatenate([step_down_p(difference.T) for difference in differences])
    assert frame["p_adjusted"].tolist() == pytest.approx(over_pairs(inside, np.repeat([0, 1, 2], 2)).tolist())
    assert frame["significant"].equals(frame["p_adjusted"] <= 0.05) and 0 < frame["significant"].sum() < 6
    assert (frame["family"] == 6).all() and (frame["pairs"] == 3).all()
    shares = [f"place_choice.share_{name}" for name in measures]
    frame = contrasts(table_of(rng.uniform(0, 0.2, size=values.shape), shares), margins=dict.fromkeys(shares, 0.2))
    assert (frame["p_equivalence"] < 0.05).sum() > frame["equivalent"].sum()
    stepped = frame["p_equivalence"].sort_values() * np.arange(6, 0, -1)
    assert frame["p_equivalence_holm"].tolist() == pytest.approx(stepped.cummax().clip(upper=1).sort_index().tolist())


def test_many_measures_need_the_seeds_of_one_and_few_seeds_cannot_win_among_many_pairs():
    measures = [f"x.m{index}" for index in range(30)]
    values = np.random.default_rng(2).normal(size=(2, 6, 30))
    values[1, :, 0] += 100
    frame = contrasts(table_of(values, measures), family=measures)
    assert frame["significant"].tolist() == [True] + [False] * 29
    assert (frame["out_of_reach"] == "").all()
    values = np.random.default_rng(2).normal(size=(5, 8, 1))
    frame = contrasts(table_of(values, ["x.one"]), family=["x.one"])
    assert frame["note"].unique().tolist() == [
        "with 8 seeds, no p value can be as low as 0.05 after correction for 10 pairs"
    ]


@pytest.mark.parametrize(("models", "seeds"), [(2, 6), (4, 8), (7, 10)])
def test_so_many_models_need_so_many_seeds(models: int, seeds: int):
    for n, is_enough in ((seeds, True), (seeds - 1, False)):
        values = 100.0 * np.arange(models)[:, None, None] + np.random.default_rng(2).normal(size=(models, n, 3))
        frame = contrasts(table_of(values, ["x.one", "x.two", "x.three"]), family=["x.one", "x.two"])
        assert frame.loc[frame["headline"], "significant"].all() == is_enough


def test_a_measure_that_is_missing_in_some_seeds_takes_part_and_can_win_last():
    values = np.random.default_rng(3).normal(size=(2, 10, 2))
    values[1, :, 0] += 100
    values[0, 8:, 0] = math.nan
    frame = contrasts(table_of(values, ["x.one", "x.two"]), family=["x.one", "x.two"]).set_index("measure")
    assert frame.loc["x.one", ["n_pairs", "significant"]].tolist() == [8, True]
    assert frame.loc["x.one", "p_adjusted"] >= 2 / 2**8
    measures = [f"x.m{index}" for index in range(9)]
    values = np.zeros((2, 10, 9))
    values[1] = np.random.default_rng(2).uniform(1, 2, size=(10, 9))
    values[:, 8:, 8] = np.nan
    last = contrasts(table_of(values, measures), family=measures).set_index("measure").loc["x.m8"]
    assert (last["n_pairs"], last["significant"]) == (8, True)
    assert last["p_adjusted"] == pytest.approx(2 / 2**8)
    assert "no p value can be" not in last["note"] and last["out_of_reach"] == ""


@pytest.mark.parametrize(("alpha", "reached"), [(2 / 2**6, True), (1.9 / 2**6, False)])
def test_the_least_p_of_six_pairs_is_within_reach_of_its_own_level(alpha: float, reached: bool):
    column = only([*runs("a", FIRST), *runs("b", SECOND)], alpha=alpha)
    assert (column["out_of_reach"] == "") is reached


def test_the_same_is_claimed_only_with_a_margin_a_range_and_six_pairs():
    near = [value + shift for value, shift in zip(FIRST, (0.01, -0.01, 0.005, 0.0, -0.005, 0.01), strict=True)]
    rows = [*runs("a", FIRST), *runs("b", near)]
    without, wide, narrow = only(rows), only(rows, margins={MEASURE: 0.5}), only(rows, margins={MEASURE: 0.1})
    assert (without["equivalent"], wide["equivalent"], narrow["equivalent"]) == (False, True, False)
    assert math.isnan(without["margin"])
    assert (wide["widest"], narrow["n_within"]) == (1, 6)
    assert wide["p_equivalence"] < 0.05 < narrow["p_equivalence"]
    column = only([*runs("a", FIRST, "path.made_up"), *runs("b", FIRST, "path.made_up")], margins={"path.made_up": 0.5})
    assert math.isnan(column["p_equivalence"]) and not column["equivalent"]
    rows = [*runs("a", FIRST[:5]), *runs("b", SECOND[:5])]
    assert math.isnan(only(rows, margins={MEASURE: 5.0})["p_equivalence"])


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"margins": {"idle_rate.chozen": 0.1}}, "Did you mean 'idle_rate.chosen'"),
        ({"margins": {MEASURE: 0.0}}, "above 0"),
        ({"margins": {MEASURE: math.nan}}, "above 0"),
        ({"margins": {MEASURE: math.inf}}, "above 0"),
        ({"family": ["nothing"]}, "Measure 'nothing' not found"),
        ({"family": ["idle_rote.chosen"]}, r"Did you mean 'idle_rate.chosen'\? Available: idle_rate.chosen\."),
    ],
)
def test_wrong_declarations_are_refused(more, message):
    with pytest.raises(InputError, match=message):
        contrasts(table([*runs("a", FIRST), *runs("b", SECOND)]), **more)


def test_baselines_are_shown_and_never_tested():
    rows = [*runs("a", FIRST, baseline=False), *runs("walker", SECOND, baseline=True, prompt="any")]
    rows += runs("a", FIRST, baseline=False, prompt="q")
    frame = contrasts(table(rows))
    assert frame["factor"].tolist() == ["prompt", "model", "model"]
    beside = frame[frame["baseline"]]
    assert beside["context"].tolist() == ["prompt=p", "prompt=q"]
    assert beside["test"].unique().tolist() == ["not tested: baseline"]
    assert beside["difference"].notna().all()
    assert not beside["headline"].any()
    assert frame[~frame["baseline"]]["family"].tolist() == [0]


def test_no_result_changes_by_the_general_measures_beside_it():
    rng = np.random.default_rng(3)
    measures = ["idle_rate.chosen", "stability.persistence", "heterogeneity.beyond_shuffled", "persona_effect.gender"]
    values = rng.normal(size=(2, 12, 4))
    alone = contrasts(table_of(values[:, :, :2], measures[:2])).set_index("measure")
    beside = contrasts(table_of(values, measures)).set_index("measure")
    for column in ("p", "p_bh", "p_adjusted", "family"):
        assert beside.loc[measures[:2], column].tolist() == alone[column].tolist()
    assert beside.loc[measures[2:], "p_bh"].notna().all() and not beside.loc[measures[2:], "headline"].any()


def test_the_default_family_holds_the_first_headline_that_each_world_has():
    drawn, fixed = "hazard.away_beyond_moved", "hazard.away_beyond_blind"
    worlds = {"drawn": {drawn: 0.4, fixed: 0.3}, "fixed": {fixed: 0.2}}
    rows = [
        {"world": world, "model": model, "seed": seed, **{name: value * seed for name, value in measures.items()}}
        for world, measures in worlds.items()
        for model in "ab"
        for seed in range(6)
    ]
    for names, declared in ((("drawn", "fixed"), {drawn, fixed}), (("drawn",), {drawn}), (("fixed",), {fixed})):
        frame = contrasts(table([row for row in rows if row["world"] in names]))
        assert set(frame.loc[frame["headline"], "measure"]) == declared
