"""Sign flips, bootstrap-t, spreads and corrections: against libraries, by hand, and on data whose truth is known."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.special import ndtri, stdtrit
from simulated_runs import CASES, coverage, simulated_table

from analysis.stats.contrasts import contrasts
from analysis.stats.equivalence import equivalence_p, fewest_for_same, most_beyond
from analysis.stats.fingerprint import energy_distance
from analysis.stats.intervals import (
    bootstrap_t,
    estimate,
    estimates,
    normal_quantile,
    student_quantile,
    wilson,
)
from analysis.stats.pairing import hedges_g_z, superiority
from analysis.stats.sign_flip import assignments, fewest_pairs, least_p, sign_flip_interval, sign_flip_p
from analysis.stats.testing import benjamini_hochberg, holm
from foundry import seeding
from signature_tables import table_of


def random(n: int, rows: int = 1) -> np.ndarray:
    return np.random.default_rng(n).normal(0.4, 1.0, size=(rows, n))


@pytest.mark.parametrize("n", [6, 9])
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


@pytest.mark.parametrize("n", [6, 18])
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
    ([math.nan], "no value"),
    ([0.5, math.nan], "one value"),
    ([0.3, 0.4, 0.5, 0.6, 0.7], "descriptive (n < 6)"),
    ([-3e8, -1e8 * (0.1 + 0.2) * 10], "no variation; descriptive (n < 6)"),
    ([0.3] * 6, "no variation"),
])  # fmt: skip
def test_what_keeps_an_interval_from_being_one_is_noted(values: list[float], note: str):
    found = estimate(np.array(values))
    assert (found.n, found.note) == (np.isfinite(values).sum(), note)
    assert math.isnan(found.low) == (note != "descriptive (n < 6)")


@pytest.mark.parametrize("n", [10, 15])
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
    estimate = estimates(np.ones((1, 10)), np.zeros(1), np.ones(1), binary=np.array([True])).row(0)
    assert (estimate.interval, estimate.note, estimate.high) == ("wilson", "", pytest.approx(1.0))
    assert estimate.low == pytest.approx(stats.binomtest(10, 10).proportion_ci(method="wilson").low)


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


EXAMPLES = json.loads(Path(__file__).with_name("worked_examples.json").read_text(encoding="utf-8"))


def example(name: str):
    return EXAMPLES[name]["inputs"], EXAMPLES[name]["expected"]


def close(expected: object) -> object:
    return pytest.approx(expected, abs=1e-9, rel=1e-9)


@pytest.mark.parametrize(("name", "method"), [("holm", holm), ("bh", benjamini_hochberg)])
def test_corrections_for_many_tests(name: str, method):
    inputs, expected = example(name)
    p = np.array([math.nan, *inputs["p"][::-1]])
    assert math.isnan(method(p)[0])
    assert method(p)[1:].tolist() == close(expected[::-1])


def test_sign_flips_have_their_least_p_refuse_a_missing_pair_and_are_mcnemars_exact_test():
    inputs, expected = example("sign_flip_min_p_n5")
    assert sign_flip_p(np.array([inputs["diffs"]]))[0] == close(expected)
    assert least_p(5) == close(expected)
    inputs, _ = example("nan_permutation_trap")
    differences = np.array([[math.nan if given is None else given for given in inputs["a"]]])
    with pytest.raises(ValueError, match="NaN"):
        sign_flip_p(differences)
    assert sign_flip_p(differences[:, ~np.isnan(differences[0])])[0] == close(0.0625)
    inputs, expected = example("mcnemar_exact")
    outcomes = [1] * inputs["only_A_succeeds"] + [-1] * inputs["only_B_succeeds"] + [0] * inputs["both"]
    differences = np.array([outcomes + [0] * inputs["neither"]], dtype=float)
    assert sign_flip_p(differences)[0] == close(expected)


def test_equivalence_is_gaffkes_bound_of_the_mean():
    differences, weights = np.array([0.1, 0.0, -0.05, 0.1]), np.random.default_rng(0).dirichlet(np.ones(5), 200_000)
    chance = (weights @ np.append(differences, 0.5) >= 0.2).mean()
    assert equivalence_p(differences, 0.2, 0.5) == pytest.approx(chance, abs=0.004)
    assert equivalence_p(-differences, 0.2, 0.5) == pytest.approx(equivalence_p(differences, 0.2, 0.5))
    assert equivalence_p(np.zeros(29), 0.1, 1.0) == close(0.9**29)
    assert math.isnan(equivalence_p(differences, 0.2, math.inf))


@pytest.mark.parametrize(("margin", "widest", "seeds"), [(0.1, 1, 29), (0.15, 1, 19), (0.3, 1, 9), (0.1, 0.3, 8)])
def test_so_many_seeds_can_be_shown_to_be_the_same(margin: float, widest: float, seeds: int):
    assert fewest_for_same(margin, widest) == seeds
    assert equivalence_p(np.zeros(seeds), margin, widest) <= 0.05 < equivalence_p(np.zeros(seeds - 1), margin, widest)


def test_the_share_that_could_differ_is_clopper_and_pearsons():
    assert [most_beyond(n, n) for n in (6, 10, 20)] == close([1 - 0.05 ** (1 / n) for n in (6, 10, 20)])
    assert stats.binom.cdf(1, 10, most_beyond(9, 10)) == close(0.05)
    assert most_beyond(0, 10) == 1


def test_the_standardised_difference_its_interval_and_cliffs_delta():
    inputs, expected = example("hedges_g_z_paired")
    found = estimate(np.array(inputs["diffs"]))
    assert hedges_g_z(np.array([found.mean]), np.array([found.sd]), found.n)[0] == close(expected)
    inputs, expected = example("cliffs_delta")
    differences = np.subtract.outer(inputs["x"], inputs["y"]).reshape(1, -1)
    assert 2 * superiority(differences)[0] - 1 == close(expected)
    inputs, expected = example("paired_t_ci")
    found = estimate(np.array(inputs["diffs"]))
    assert [found.low, found.high] == close(expected)


def test_the_interval_of_a_rate_and_the_energy_distance():
    inputs, expected = example("wilson_interval")
    low, high = wilson(np.array([inputs["k"] / inputs["n"]]), inputs["n"])
    assert [low[0], high[0]] == close(expected)
    inputs, expected = example("energy_distance")
    first, second = (np.array(inputs[name])[:, None] for name in ("x", "y"))
    assert energy_distance(first, second) == close(expected)


def normal(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    return rng.normal(size=shape)


def chance_error(rate: float, count: int, sigmas: float = 3.5) -> float:
    """Return how far a share of `count` independent events may be from its rate."""
    return sigmas * math.sqrt(rate * (1 - rate) / count)


def test_one_test_in_twenty_is_wrong_when_nothing_differs():
    values = np.random.default_rng(11).normal(size=(1, 10, 2000)) + normal(np.random.default_rng(12), (2, 10, 2000))
    p = contrasts(simulated_table(values))["p"]
    reachable = math.floor(0.05 * 2**9) / 2**9
    assert (p <= 0.05).mean() == pytest.approx(reachable, abs=chance_error(reachable, 2000))


def test_ninety_five_intervals_in_a_hundred_hold_the_mean():
    found = coverage(CASES[0], 10, 2000, np.random.default_rng(15))
    assert found["covered"] == pytest.approx(0.95, abs=chance_error(0.95, 2000) + 0.005)


@pytest.mark.parametrize("seeds", [6, 10])
def test_a_model_that_fails_in_one_seed_of_ten_is_seldom_called_the_same(seeds: int):
    fails = np.random.default_rng(seeds).random((1, seeds, 1000)) < 0.1
    names = [f"place_choice.share_{index}" for index in range(1000)]
    frame = contrasts(table_of(np.concatenate([0 * fails, fails]), names), margins=dict.fromkeys(names, 0.1))
    assert (frame["p_equivalence"] <= 0.05).mean() <= 0.05 + chance_error(0.05, 1000)


def test_the_tabled_quantiles_are_those_of_scipy():
    assert [student_quantile(freedom) for freedom in range(1, 45)] == [stdtrit(n, 0.975) for n in range(1, 45)]
    assert normal_quantile() == ndtri(0.975)
    assert normal_quantile(0.9) == ndtri(0.95)
