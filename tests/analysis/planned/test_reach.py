"""What a sweep can find, said before it runs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from analysis.planned.reach import CHANCE, reach_of, sure_effect
from analysis.stats.max_t import step_down_p
from planning import condition


def reached(models: str, worlds: int = 1, seeds: int = 12):
    conditions = [
        condition(model, world=f"w{world}", seeds=range(seeds)) for world in range(worlds) for model in models
    ]
    return reach_of(conditions, ["grid"] * len(conditions))


@pytest.mark.parametrize(
    ("models", "worlds", "fewest"), [("ab", 1, 6), ("abc", 1, 7), ("abcd", 1, 8), ("abcde", 1, 9), ("abcde", 4, 11)]
)
def test_a_test_needs_more_seeds_the_more_pairs_there_are(models: str, worlds: int, fewest: int):
    assert reached(models, worlds).fewest == fewest
    few = reached(models, worlds, seeds=fewest - 1)
    assert not few.is_enough and math.isnan(few.effect)
    assert few.line().endswith(
        f"need{'s' * (models == 'ab')} at least {fewest} seeds: with {fewest - 1} no difference can be claimed"
    )


def test_a_single_condition_compares_nothing_and_more_seeds_find_smaller_differences():
    assert reached("a") is None
    sizes = [sure_effect(seeds, 3, 5) for seeds in (8, 12, 20, 30)]
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize(
    ("seeds", "pairs", "measures"), [(8, 1, 5), (10, 3, 3), pytest.param(20, 3, 5, marks=pytest.mark.slow)]
)
def test_the_promised_difference_is_found_as_often_by_the_test_in_use(seeds: int, pairs: int, measures: int):
    effect = sure_effect(seeds, pairs, measures)
    draws = np.random.default_rng(5)
    shift = np.zeros((measures, 1))
    shift[0] = effect
    p = [step_down_p(draws.standard_normal((measures, seeds)) + shift)[0] for _ in range(200)]
    assert np.mean(np.array(p) * pairs <= 0.05) == pytest.approx(CHANCE, abs=0.09)
