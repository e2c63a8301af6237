"""What was declared, tested at the looks that the runs have reached."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from analysis.stats.contrasts import COLUMNS, contrasts
from analysis.stats.equivalence import equivalence_p
from analysis.stats.max_t import step_down_p
from analysis.stats.plan import Plan
from analysis.stats.sequential import levels, sequential_p
from analysis.stats.sign_flip import sign_flip_p
from signature_tables import table_of

MEASURES = ("idle_rate.chosen", "movement.move_rate", "clustering.nni")
LOOKS = (6, 9, 12)
VALUES = np.random.default_rng(3).normal(size=(2, 14, 3)) + np.array([0, 0.9])[:, None, None]
PLAN = Plan(MEASURES[:2], frozenset({("a",), ("b",)}), LOOKS, tuple(range(12)), 2)


def rows(values: np.ndarray = VALUES, plan: Plan = PLAN, **more) -> pd.DataFrame:
    return contrasts(table_of(values, MEASURES), plan=plan, **more).set_index("measure")


def p_by_hand(measure: int, seeds: list[list[int]]) -> np.ndarray:
    difference = VALUES[1, :, measure] - VALUES[0, :, measure]
    return np.array([sign_flip_p(difference[None, own]) for own in seeds])


def test_declared_rows_say_their_look_and_level_and_correct_over_measures_and_looks_together():
    frame = rows()
    assert frame["claim"].to_dict() == dict(zip(MEASURES, ["declared", "declared", "exploratory"], strict=True))
    assert frame["look"].tolist() == [2, 2, 0]
    assert frame["alpha"].tolist()[:2] == pytest.approx([levels(LOOKS, np.array([0.05]))[1, 0]] * 2)
    seeds = [list(range(6)), list(range(9))]
    corrected = [step_down_p((VALUES[1, own, :2] - VALUES[0, own, :2]).T) for own in seeds]
    assert rows()["p_adjusted"].tolist()[:2] == pytest.approx(sequential_p(LOOKS, np.array(corrected)).tolist())
    assert rows()["p"].tolist()[:2] == pytest.approx([p_by_hand(measure, seeds[1:]).item() for measure in range(2)])


def test_seeds_after_a_look_change_no_claim():
    more = VALUES.copy()
    more[:, 9:] += 100 * np.random.default_rng(0).normal(size=more[:, 9:].shape)
    columns = [name for name in COLUMNS if name not in ("measure", "note")]
    pd.testing.assert_frame_equal(rows(VALUES[:, :9])[columns].iloc[:2], rows(more)[columns].iloc[:2])
    assert rows(more)["note"].iloc[0].startswith("over all 14 seeds the difference is ")


def test_a_verdict_has_the_numbers_of_the_look_that_decided_it():
    turned = np.random.default_rng(4).normal(0, 0.05, size=(2, 12, 2))
    turned[1, :8] += 0.4
    turned[0, 8:] += 0.9
    plan = replace(PLAN, looks=(8, 12), reached=2)
    column = contrasts(table_of(turned, MEASURES[:2]), plan=plan).iloc[0]
    early = contrasts(table_of(turned[:, :8], MEASURES[:2]), plan=replace(plan, reached=1)).iloc[0]
    own = [name for name in COLUMNS if name != "note"]
    assert (column["look"], column["n_pairs"], column["significant"]) == (1, 8, True)
    assert column["low"] > 0 and (turned[1] - turned[0]).mean(axis=0)[0] < 0
    pd.testing.assert_series_equal(column[own], early[own], check_names=False)
    assert column["note"].startswith("over all 12 seeds the difference is -0.")


def test_looks_follow_the_order_of_the_plan_and_nothing_is_claimed_before_the_first():
    backwards = replace(PLAN, seeds=tuple(reversed(range(14))), reached=1)
    assert rows(plan=backwards)["p"].iloc[0] == pytest.approx(p_by_hand(0, [list(range(8, 14))]).item())
    column = rows(plan=replace(PLAN, reached=0)).iloc[0]
    assert (column["test"], column["look"], column["significant"]) == ("not tested: before the first look", 0, False)
    assert math.isnan(column["p_adjusted"])


def test_the_declared_family_holds_no_other_group_and_keeps_what_never_differs():
    values = np.concatenate([VALUES, VALUES[:1] + 2])
    frame = contrasts(table_of(values, MEASURES), plan=PLAN)
    declared = frame[frame["claim"] == "declared"]
    assert set(declared["level"] + declared["reference"]) == {"ba"}
    assert declared["family"].tolist() == [2, 2]
    flat = VALUES.copy()
    flat[1, :, 1] = flat[0, :, 1]
    frame = rows(flat)
    assert frame["family"].tolist()[:2] == [2, 2]
    assert math.isnan(frame["p_adjusted"].iloc[1])
    assert frame["p_adjusted"].iloc[0] == pytest.approx(
        sequential_p(LOOKS, p_by_hand(0, [list(range(6)), list(range(9))])).item()
    )


def test_the_same_within_a_margin_is_shown_over_looks_too():
    values = np.random.default_rng(5).normal(size=(2, 12, 3)) * 0.05
    margins = {MEASURES[0]: 0.3}
    planned = rows(values, replace(PLAN, margins=margins, reached=3)).iloc[0]
    fixed = rows(values, replace(PLAN, margins=margins, looks=(12,), reached=1)).iloc[0]
    seen = [(values[1] - values[0])[:n, 0] for n in LOOKS]
    p = np.array([equivalence_p(one, 0.3, 1.0) for one in seen])[:, None]
    assert planned["p_equivalence"] == pytest.approx(sequential_p(LOOKS, 2 * p).item() / 2)
    assert planned["p_equivalence"] < 0.5
    assert fixed["p_equivalence"] == pytest.approx(
        contrasts(table_of(values, MEASURES), margins=margins).iloc[0]["p_equivalence"]
    )
    late = rows(values, replace(PLAN, margins=margins, reached=0)).iloc[0]
    assert math.isnan(late["p_equivalence"])


def test_values_that_are_equal_in_each_seed_are_the_same_and_those_beyond_a_margin_are_not():
    equal = np.repeat(VALUES[:1], 2, axis=0)
    margins = {MEASURES[0]: 0.3}
    for looks, p in (((8,), 0.7**8), ((9,), 0.7**9)):
        column = rows(equal, replace(PLAN, margins=margins, looks=looks, reached=1)).iloc[0]
        assert (column["p_equivalence"], column["equivalent"]) == (pytest.approx(p), p <= 0.05)
    far = VALUES.copy()
    far[1] += 5
    assert rows(far, replace(PLAN, margins={MEASURES[0]: 0.3}))["p_equivalence"].iloc[0] == 1


def test_what_no_seed_goes_beyond_may_be_declared_and_a_seed_that_does_refutes_it():
    margins, measure = {"movement.path": 0.1}, "movement.path"
    plan = Plan((measure,), PLAN.groups, (10,), tuple(range(10)), 1, margins, {measure: 0.3})
    near = np.zeros((2, 12, 1))
    near[1, :, 0] = [0.05, -0.05] * 6
    plans = plan, replace(plan, widest={})
    column, without = (contrasts(table_of(near, [measure]), plan=plan).iloc[0] for plan in plans)
    assert (column["widest"], column["n_within"], column["equivalent"]) == (0.3, 10, True)
    assert math.isnan(without["p_equivalence"]) and not without["equivalent"]
    near[1, 11] = 0.4
    column = contrasts(table_of(near, [measure]), plan=plan).iloc[0]
    assert (column["p_equivalence"], column["equivalent"]) == (1, False)
    assert "one seed differs by 0.4, more than --widest 0.3: equality cannot be claimed" in column["note"]


def test_a_look_at_which_no_p_is_small_enough_says_so_with_its_own_seeds():
    found = rows(plan=replace(PLAN, reached=1))["note"].iloc[0]
    assert found.startswith(
        "with 6 seeds, no p value can be as low as 0.05 after correction for 1 pair at this look; "
        "over all 14 seeds the "
    )
    assert "no p value can" not in rows(plan=replace(PLAN, reached=3))["note"].iloc[0]
