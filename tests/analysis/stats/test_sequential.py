"""Levels of several looks at growing data, and p over the measures of a pair and over the pairs."""

import itertools

import numpy as np
import pytest
from scipy.special import ndtr

from analysis.stats.max_t import over_pairs, step_down_p
from analysis.stats.sequential import levels, sequential_p
from analysis.stats.sign_flip import DRAWS, sign_flip_p
from analysis.stats.testing import holm

LOOKS = (8, 12, 18, 26, 34)
SIZES = np.array([0.31, 1.7, 0.52, 0.93, 2.2, 0.77, 1.1, 0.44, 0.65, 1.9])
"""Differences without their signs."""


def test_a_single_look_has_the_whole_level_and_levels_grow_with_the_error_in_all():
    assert levels((20,), np.array([0.05, 0.01]))[0] == pytest.approx([0.05, 0.01])
    assert (np.diff(levels(LOOKS, np.geomspace(1e-6, 0.9, 30)), axis=1) > 0).all()


def test_each_look_spends_its_share_of_the_pairs():
    walks = np.random.default_rng(0).normal(size=(60_000, LOOKS[-1])).cumsum(axis=1)[:, np.array(LOOKS) - 1]
    p = 2 * ndtr(-np.abs(walks) / np.sqrt(LOOKS))
    passed = np.logical_or.accumulate(p <= levels(LOOKS, np.array([0.05]))[:, 0], axis=1).mean(axis=0)
    assert passed == pytest.approx(0.05 * np.array(LOOKS) / LOOKS[-1], abs=0.003)


def test_a_p_at_the_level_of_a_look_is_the_error_in_all_and_what_was_significant_stays_so():
    error = np.array([0.05, 0.0123, 0.3])
    for look, own in enumerate(levels(LOOKS, error)):
        p = np.ones((look + 1, 3))
        p[look] = own
        assert sequential_p(LOOKS, p) == pytest.approx(error, rel=1e-5)
    first = np.array([[0.001], [0.9]])
    assert sequential_p(LOOKS, first) == sequential_p(LOOKS, first[:1]) < 0.05
    assert sequential_p(LOOKS, np.full((2, 1), np.nan)).tolist() == [1.0], "rows without a test have no small p"


@pytest.mark.parametrize("looks", [(7, 10), (6, 7, 8, 9, 10)])
def test_over_all_signs_the_exact_test_errs_no_more_often_than_was_declared(looks):
    every_sign = SIZES * np.array(list(itertools.product((1.0, -1.0), repeat=len(SIZES))))
    p = np.array([sign_flip_p(every_sign[:, :n]) for n in looks])
    corrected = sequential_p(looks, p)
    assert all((corrected <= alpha).mean() <= alpha for alpha in (0.025, 0.05, 0.1))
    assert (p <= 0.1).any(axis=0).mean() > 0.1 and (corrected <= 0.1).mean() > 0.05


def by_hand(differences: np.ndarray) -> list[float]:
    """Return the corrected p of each row, by its definition over all assignments of signs."""
    values = np.nan_to_num(differences)
    statistic = lambda signs: np.abs(values @ signs) / np.sqrt((values**2).sum(axis=1))  # noqa: E731
    nulls = np.array([statistic(np.array(signs)) for signs in itertools.product((1, -1), repeat=values.shape[1])])
    observed, found, least = statistic(np.ones(values.shape[1])), np.empty(len(values)), 0.0
    order = np.argsort(-observed)
    for place, row in enumerate(order):
        largest = nulls[:, order[place:]].max(axis=1)
        found[row] = least = max(least, float((largest >= observed[row] - 1e-9).mean()))
    return found.tolist()


def test_max_t_is_its_definition_over_all_assignments_and_copies_and_units_of_a_measure_change_nothing():
    differences = np.random.default_rng(0).normal(size=(4, 8)) + np.array([0, 0.5, 1, 2])[:, None]
    differences[1, 2] = differences[3, 0] = np.nan
    assert step_down_p(differences).tolist() == pytest.approx(by_hand(differences))
    one = np.random.default_rng(1).normal(size=(1, 10)) + 1
    assert step_down_p(np.repeat(one, 5, axis=0)) == pytest.approx(np.repeat(sign_flip_p(one), 5))
    differences = np.random.default_rng(3).normal(size=(3, 9)) + 0.4
    assert step_down_p(differences * np.array([1e-6, 1, 1e6])[:, None]) == pytest.approx(step_down_p(differences))
    differences = np.random.default_rng(4).normal(size=(3, 40)) + 2
    assert step_down_p(differences).tolist() == step_down_p(differences).tolist() == [1 / (DRAWS + 1)] * 3


def test_pairs_are_corrected_by_holm_until_all_measures_of_one_are_smaller():
    p = np.array([0.04, 0.001, np.nan, 0.02, 0.5])
    assert over_pairs(p, np.arange(5)) == pytest.approx(holm(p), nan_ok=True)
    p = np.array([0.001, 0.3, 0.02, 0.5, 0.01])
    pair = np.array([0, 0, 1, 1, 2])
    assert over_pairs(p, pair).tolist() == pytest.approx([0.003, 0.6, 0.04, 0.6, 0.03])
