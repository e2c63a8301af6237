"""How many seeds a difference needs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from analysis.stats.power import paired_power, pairs_needed, power, sd_bound
from analysis.stats.sign_flip import sign_flip_p
from foundry.errors import InputError
from signature_tables import runs, table

FIRST = [0.1, 0.5, 0.3, 0.2, 0.9, 0.4, 0.6, 0.3]
SECOND = [0.2, 0.7, 0.3, 0.6, 0.9, 0.8, 0.7, 0.1]


def pilot(**more):
    return power(table([*runs("a", FIRST), *runs("b", SECOND)]), **more).iloc[0]


def test_the_seeds_that_known_effects_need():
    effects = np.array([0.5, 0.8, 1.0, 1.5, math.nan, 0.0])
    found = pairs_needed(effects, np.full(6, 0.05), 0.8)
    assert found[:4].tolist() == [34, 15, 10, 6]
    assert np.isnan(found[4:]).all()


@pytest.mark.parametrize(("effect", "n", "level"), [(0.7, 12, 0.01), (1.5, 6, 0.05), (0.2, 150, 0.001), (3.0, 3, 0.05)])
def test_the_power_is_that_of_the_noncentral_t(effect, n, level):
    critical, centre = stats.t.ppf(1 - level / 2, n - 1), effect * math.sqrt(n)
    expected = stats.nct.sf(critical, n - 1, centre) + stats.nct.cdf(-critical, n - 1, centre)
    found = paired_power(np.array([effect]), np.array([n]), np.array([level]))
    assert found[0] == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize(("effect", "seeds"), [(1.5, 7), (1.0, 11), pytest.param(0.8, 16, marks=pytest.mark.slow)])
def test_the_promised_seeds_give_the_promised_power_by_the_test_in_use(effect: float, seeds: int):
    normal = np.random.default_rng(0).normal(size=200)
    wanted = effect * normal.std(ddof=1)
    found = power(table([*runs("a", [0] * 200), *runs("b", normal.tolist())]), difference=wanted).iloc[0]
    assert found["n_alone"] == seeds
    again = np.random.default_rng(1).normal(wanted, size=(1_000, seeds))
    assert (sign_flip_p(again) <= 0.05).mean() > 0.78


def test_a_pilot_gives_its_own_difference_and_large_ones_still_need_six_seeds():
    found = pilot()
    differences = np.subtract(SECOND, FIRST)
    assert (found["observed"], found["sd"]) == pytest.approx((differences.mean(), differences.std(ddof=1)))
    assert found["difference"] == abs(found["observed"])
    assert (found["n_pairs"], found["family"], found["n_exact"]) == (8, 1, 6)
    assert found["n_alone"] == found["n_family"] < found["n_cautious"]
    found = pilot(difference=5.0)
    assert (found["n_alone"], found["n_family"]) == (6, 6)


def test_the_cautious_spread_is_exceeded_in_one_of_five_pilots():
    pilots = np.random.default_rng(0).normal(size=(20_000, 8)).std(axis=1, ddof=1)
    assert (sd_bound(pilots, np.full(20_000, 8.0)) < 1).mean() == pytest.approx(0.2, abs=0.01)


@pytest.mark.slow
def test_more_tests_need_more_seeds():
    scale = {"a": 1, "b": 2, "c": 3, "d": 4, "e": 4}
    rows = [run for model, factor in scale.items() for run in runs(model, np.multiply(FIRST, factor).tolist())]
    found = power(table(rows), difference=0.3)
    assert found["family"].unique().tolist() == [9]
    assert found["n_exact"].unique().tolist() == [9]
    varying = found[found["sd"] > 0]
    assert len(varying) == 9
    assert (varying["n_family"] > varying["n_alone"]).all()


@pytest.mark.parametrize(
    ("second", "note"),
    [
        ([value + 0.1 for value in FIRST], "no variation in the pilot"),
        ([0.1, *[math.nan] * 7], "fewer than two pairs"),
        ([0.5, 0.1, 0.3, 0.2, 0.9, 0.4, 0.6, 0.3], "no difference to find"),
    ],
)
def test_what_a_pilot_cannot_tell_is_said(second, note):
    found = power(table([*runs("a", FIRST), *runs("b", second)])).iloc[0]
    assert found["note"] == note
    assert math.isnan(found["n_cautious"])


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"measure": "idle_rate.chozen"}, "Did you mean 'idle_rate.chosen'"),
        ({"difference": -0.1}, "above 0"),
        ({"target": 80.0}, "between 0 and 1"),
    ],
)
def test_wrong_wishes_are_refused(more, message):
    with pytest.raises(InputError, match=message):
        pilot(**more)
