"""Groups as a whole."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest

from analysis.stats.fingerprint import energy_distance, fingerprint, swap_p
from signature_tables import runs, table, table_of

MEASURES = ["x.one", "x.two", "x.three"]


def two_alike_one_other(seeds: int = 8) -> np.ndarray:
    """Return three models of which the first two are alike (3, seeds, 3)."""
    noise = np.random.default_rng(4).normal(0, 0.1, size=(3, seeds, 3))
    return noise + np.array([0.0, 0.05, 3.0])[:, None, None]


def test_models_that_are_alike_merge_first_and_always():
    found = fingerprint(table_of(two_alike_one_other(), MEASURES), measures=MEASURES)
    assert found.linkage is not None
    assert set(found.linkage[0, :2].tolist()) == {0, 1}
    assert found.support.tolist() == [1.0, 1.0]
    assert (found.levels, found.measures, found.seeds) == (("a", "b", "c"), tuple(MEASURES), tuple(range(8)))


def test_standardised_measures_have_mean_zero_over_levels_and_no_unit():
    values = two_alike_one_other()
    found, scaled = (fingerprint(table_of(values * k, MEASURES), measures=MEASURES) for k in (1, 1000))
    assert found.z.mean().tolist() == pytest.approx([0, 0, 0], abs=1e-12)
    assert found.z.to_numpy() == pytest.approx(scaled.z.to_numpy())


def test_the_energy_test_swaps_labels_within_seeds():
    first, second = (np.random.default_rng(seed).normal(size=(6, 2)) + seed for seed in (0, 1))
    observed = energy_distance(first, second)
    swapped = []
    for swap in product([False, True], repeat=6):
        chosen = np.array(swap)[:, None]
        swapped.append(energy_distance(np.where(chosen, second, first), np.where(chosen, first, second)))
    assert swap_p(first, second) == pytest.approx(np.mean(np.array(swapped) >= observed - 1e-9))


def test_models_that_differ_are_told_apart_and_corrected_for_all_pairs():
    energy = fingerprint(table_of(two_alike_one_other(10), MEASURES), measures=MEASURES).energy
    p = dict(zip(zip(energy["level"], energy["reference"], strict=True), energy["p_holm"], strict=True))
    assert p["c", "a"] == pytest.approx(3 * 2 / 2**10)
    assert p["b", "a"] > 0.05


def test_neither_seeds_of_failed_runs_nor_what_is_undefined_is_compared():
    values = two_alike_one_other()
    values[1, 2, 0], values[:, :, 1] = math.nan, 0.5
    found = fingerprint(table_of(values, MEASURES), measures=MEASURES)
    assert found.measures == ("x.three",)
    assert dict(found.dropped) == {"x.one": "undefined in a run", "x.two": "no variation"}
    made = table_of(two_alike_one_other(), MEASURES)
    made.frame.loc[3, "status"] = "failed"
    made.frame.loc[3, MEASURES] = math.nan
    assert fingerprint(made, measures=MEASURES).seeds == (0, 1, 2, 4, 5, 6, 7)


def test_five_seeds_are_not_tested():
    energy = fingerprint(table_of(two_alike_one_other(5), MEASURES), measures=MEASURES).energy
    assert energy["p"].isna().all()
    assert energy["note"].unique().tolist() == ["not tested: n < 6"]
    assert energy["statistic"].notna().all()


@pytest.mark.parametrize("rows", [runs("a", [0.1, 0.2]), [*runs("a", [0.1] * 6), *runs("b", [0.1] * 6)]])
def test_with_nothing_to_compare_there_is_no_tree(rows):
    found = fingerprint(table(rows))
    assert found.linkage is None
    assert len(found.support) == len(found.energy) == 0


def test_baselines_are_no_level():
    rows = [*runs("a", [0.1, 0.3], baseline=False), *runs("b", [0.2, 0.7], baseline=False)]
    found = fingerprint(table([*rows, *runs("walker", [0.5, 0.6], baseline=True)]))
    assert found.levels == ("a", "b")
    assert found.measures == ("idle_rate.chosen",)
