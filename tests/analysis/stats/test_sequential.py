"""Levels of several looks at growing data."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from analysis.stats.sequential import levels, sequential_p
from analysis.stats.sign_flip import sign_flip_p

LOOKS = (8, 12, 18, 26, 34)
SIZES = np.array([0.31, 1.7, 0.52, 0.93, 2.2, 0.77, 1.1, 0.44, 0.65, 1.9])
"""Differences without their signs."""


@pytest.fixture(scope="module")
def every_sign() -> np.ndarray:
    """Return the differences with every assignment of signs (1024, 10), each as likely where nothing differs."""
    return SIZES * np.array(list(product((1.0, -1.0), repeat=len(SIZES))))


def p_at(looks: tuple[int, ...], differences: np.ndarray) -> np.ndarray:
    return np.array([sign_flip_p(differences[:, :n]) for n in looks])


def test_a_single_look_has_the_whole_level_and_levels_grow_with_the_error_in_all():
    assert levels((20,), np.array([0.05, 0.01]))[0] == pytest.approx([0.05, 0.01])
    assert (np.diff(levels(LOOKS, np.geomspace(1e-6, 0.9, 30)), axis=1) > 0).all()


def test_each_look_spends_its_share_of_the_pairs():
    walks = np.random.default_rng(0).normal(size=(60_000, LOOKS[-1])).cumsum(axis=1)[:, np.array(LOOKS) - 1]
    from scipy.special import ndtr

    p = 2 * ndtr(-np.abs(walks) / np.sqrt(LOOKS))
    passed = np.logical_or.accumulate(p <= levels(LOOKS, np.array([0.05]))[:, 0], axis=1).mean(axis=0)
    assert passed == pytest.approx(0.05 * np.array(LOOKS) / LOOKS[-1], abs=0.003)


@pytest.mark.parametrize("look", range(5))
def test_a_p_at_the_level_of_a_look_is_the_error_in_all(look):
    error = np.array([0.05, 0.0123, 0.3])
    p = np.ones((look + 1, 3))
    p[look] = levels(LOOKS, error)[look]
    assert sequential_p(LOOKS, p) == pytest.approx(error, rel=1e-5)


def test_what_was_significant_stays_so_and_rows_without_a_test_have_no_small_p():
    first = np.array([[0.001], [0.9]])
    assert sequential_p(LOOKS, first) == sequential_p(LOOKS, first[:1]) < 0.05
    assert sequential_p(LOOKS, np.full((2, 1), np.nan)).tolist() == [1.0]


@pytest.mark.parametrize("looks", [(7, 10), (6, 7, 8, 9, 10), (8, 9, 10)])
def test_over_all_signs_the_exact_test_errs_no_more_often_than_was_declared(every_sign, looks):
    p = p_at(looks, every_sign)
    corrected = sequential_p(looks, p)
    assert all((corrected <= alpha).mean() <= alpha for alpha in (0.025, 0.05, 0.1))
    assert (p <= 0.1).any(axis=0).mean() > 0.1 and (corrected <= 0.1).mean() > 0.05
