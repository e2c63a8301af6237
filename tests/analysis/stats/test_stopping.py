"""How often a difference is found at several looks, and when."""

from __future__ import annotations

import math

import numpy as np
import pytest

from analysis.stats.power import power
from analysis.stats.sequential import levels
from analysis.stats.sign_flip import sign_flip_p
from analysis.stats.stopping import error_of, with_looks
from signature_tables import runs, table

LOOKS = (8, 12, 18, 26, 34)


@pytest.mark.slow
@pytest.mark.parametrize("effect", [0.5, 1.5])
def test_the_promised_power_and_seeds_are_those_of_the_test_in_use(effect: float):
    normal = np.random.default_rng(0).normal(size=200)
    plan = power(table([*runs("a", [0] * 200), *runs("b", normal.tolist())]), difference=effect * normal.std(ddof=1))
    promised = with_looks(plan, LOOKS).iloc[0]
    sweeps = np.random.default_rng(1).normal(effect, size=(1_000, LOOKS[-1]))
    by_look = levels(LOOKS, np.array([0.05]))[:, 0]
    significant = np.stack([sign_flip_p(sweeps[:, :n]) <= level for n, level in zip(LOOKS, by_look, strict=True)])
    ended = np.where(significant.any(axis=0), np.array(LOOKS)[significant.argmax(axis=0)], LOOKS[-1])
    assert promised["power"] == pytest.approx(significant.any(axis=0).mean(), abs=0.07)
    assert promised["seeds"] == pytest.approx(ended.mean(), abs=1.5)


@pytest.mark.parametrize(("count", "error"), [(1, 0.050), (2, 0.083), (3, 0.107), (5, 0.142), (10, 0.193)])
def test_many_seeds_at_equal_steps_err_as_often_as_was_published(count, error):
    """Armitage, McPherson and Rowe 1969, table 2."""
    assert error_of(tuple(range(100, 100 * count + 1, 100)), 0.05) == pytest.approx(error, abs=0.009)


def test_few_seeds_err_more_often_than_many():
    assert error_of((8, 12, 18), 0.05) > error_of((80, 120, 180), 0.05) > 0.09


@pytest.mark.slow
def test_a_plan_is_cautious_of_its_family_and_without_a_difference_has_no_power():
    first = np.random.default_rng(0).random(8)
    rows = [run for place, model in enumerate("abc") for run in runs(model, np.roll(first, place).tolist())]
    plan = power(table(rows), difference=0.4)
    found = with_looks(plan, LOOKS).iloc[0]
    alone = with_looks(plan.assign(pairs=1), LOOKS).iloc[0]
    assert found["power_cautious"] < found["power"] < alone["power"]
    assert found["seeds_cautious"] > found["seeds"] > alone["seeds"]
    plan = power(table([*runs("a", [0.1] * 8), *runs("b", [0.1] * 8)]))
    assert math.isnan(with_looks(plan, LOOKS).iloc[0]["power"])
