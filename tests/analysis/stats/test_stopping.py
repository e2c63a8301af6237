"""How often a difference is found at several looks, and when."""

from __future__ import annotations

import math

import numpy as np
import pytest

from analysis.stats.power import paired_power, power
from analysis.stats.stopping import error_of, stopped, with_looks
from signature_tables import runs, table

LOOKS = (8, 12, 18, 26, 34)


def test_a_single_look_has_the_power_of_the_noncentral_t():
    effect, level = np.array([0.3, 0.5, 0.9]), np.full(3, 0.05)
    found = stopped((20,), effect, level)
    assert found.power == pytest.approx(paired_power(effect, np.full(3, 20), level), abs=0.025)
    assert found.seeds.tolist() == [20.0] * 3


@pytest.mark.parametrize(("count", "error"), [(1, 0.050), (2, 0.083), (3, 0.107), (5, 0.142), (10, 0.193)])
def test_many_seeds_at_equal_steps_err_as_often_as_was_published(count, error):
    """Armitage, McPherson and Rowe 1969, table 2."""
    assert error_of(tuple(range(100, 100 * count + 1, 100)), 0.05) == pytest.approx(error, abs=0.009)


def test_few_seeds_err_more_often_than_many():
    assert error_of((8, 12, 18), 0.05) > error_of((80, 120, 180), 0.05) > 0.09


def test_nothing_is_found_no_more_often_than_alpha():
    assert stopped(LOOKS, np.zeros(2), np.array([0.05, 0.01])).power == pytest.approx([0.05, 0.01], abs=0.008)


def test_large_differences_end_a_sweep_early_and_small_ones_late():
    found = stopped(LOOKS, np.array([0.5, 0.8, 1.0, 1.5, 9.0, math.nan]), np.full(6, 0.05))
    assert found.seeds[:5] == pytest.approx([25.5, 16.8, 13.0, 9.1, 8.0], abs=0.5)
    assert found.power[0] == pytest.approx(0.74, abs=0.02)
    assert math.isnan(found.power[5]) and math.isnan(found.seeds[5])


def test_a_plan_is_cautious_and_of_its_family():
    first = np.random.default_rng(0).random(8)
    rows = [run for place, model in enumerate("abc") for run in runs(model, np.roll(first, place).tolist())]
    plan = power(table(rows), difference=0.4)
    found = with_looks(plan, LOOKS).iloc[0]
    alone = with_looks(plan.assign(family=1), LOOKS).iloc[0]
    assert found["power_cautious"] < found["power"] < alone["power"]
    assert found["seeds_cautious"] > found["seeds"] > alone["seeds"]
