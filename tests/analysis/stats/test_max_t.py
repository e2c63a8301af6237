"""Step-down max-T inside a pair, and Holm's correction over the pairs."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from analysis.stats.max_t import over_pairs, step_down_p
from analysis.stats.multiplicity import holm
from analysis.stats.sign_flip import DRAWS, sign_flip_p


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


def test_it_is_its_definition_over_all_assignments_also_where_values_are_missing():
    differences = np.random.default_rng(0).normal(size=(4, 8)) + np.array([0, 0.5, 1, 2])[:, None]
    differences[1, 2] = differences[3, 0] = np.nan
    assert step_down_p(differences).tolist() == pytest.approx(by_hand(differences))


def test_copies_and_units_of_a_measure_change_nothing():
    one = np.random.default_rng(1).normal(size=(1, 10)) + 1
    assert step_down_p(one) == pytest.approx(sign_flip_p(one))
    assert step_down_p(np.repeat(one, 5, axis=0)) == pytest.approx(np.repeat(sign_flip_p(one), 5))
    differences = np.random.default_rng(3).normal(size=(3, 9)) + 0.4
    assert step_down_p(differences * np.array([1e-6, 1, 1e6])[:, None]) == pytest.approx(step_down_p(differences))
    differences = np.random.default_rng(4).normal(size=(3, 40)) + 2
    assert step_down_p(differences).tolist() == step_down_p(differences).tolist() == [1 / (DRAWS + 1)] * 3


def test_it_lies_between_the_single_test_and_bonferroni_and_steps_down_in_its_order():
    differences = np.random.default_rng(2).normal(size=(6, 12)) + 0.5
    alone, found = sign_flip_p(differences), step_down_p(differences)
    scale = np.sqrt((differences**2).sum(axis=1))
    order = np.argsort(-np.abs(differences.sum(axis=1)) / scale)
    assert (found >= alone - 1e-12).all() and (found <= np.minimum(6 * alone.max(), 1) + 1e-12).all()
    assert (np.diff(found[order]) >= 0).all()


def test_pairs_are_corrected_by_holm_until_all_measures_of_one_are_smaller():
    p = np.array([0.04, 0.001, np.nan, 0.02, 0.5])
    assert over_pairs(p, np.arange(5)) == pytest.approx(holm(p), nan_ok=True)
    p = np.array([0.001, 0.3, 0.02, 0.5, 0.01])
    pair = np.array([0, 0, 1, 1, 2])
    assert over_pairs(p, pair).tolist() == pytest.approx([0.003, 0.6, 0.04, 0.6, 0.03])


@pytest.mark.slow
def test_a_false_claim_is_made_in_one_of_twenty_tables_also_where_some_measures_differ():
    rng, tables, errors = np.random.default_rng(5), 300, 0
    pairs = list(itertools.combinations(range(3), 2))
    for _ in range(tables):
        values = rng.normal(size=(3, 10, 6)) + rng.normal(size=(1, 10, 6))
        values[2, :, :3] += 6
        inside = np.array([step_down_p((values[b] - values[a]).T) for a, b in pairs])
        found = over_pairs(inside.ravel(), np.repeat(np.arange(3), 6)).reshape(inside.shape)
        errors += bool((found[0] <= 0.05).any() or (found[1:, 3:] <= 0.05).any())
    assert errors <= 0.05 * tables + 3.5 * (0.05 * 0.95 * tables) ** 0.5
