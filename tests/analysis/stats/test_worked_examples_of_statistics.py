"""The formulas against values that were checked with independent libraries."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from analysis.stats.equivalence import equivalence_p, fewest_for_same, most_beyond
from analysis.stats.fingerprint import energy_distance
from analysis.stats.intervals import estimate, wilson
from analysis.stats.multiplicity import benjamini_hochberg, holm
from analysis.stats.paired import hedges_g_z, superiority
from analysis.stats.sign_flip import least_p, sign_flip_p

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
    differences = np.array([[math.nan if one is None else one for one in inputs["a"]]])
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
