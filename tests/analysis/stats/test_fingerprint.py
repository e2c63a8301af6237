"""Groups as a whole, and variance components."""

import math
from itertools import product

import numpy as np
import pandas as pd
import pytest
from scipy.cluster.hierarchy import linkage

from analysis.stats.fingerprint import RESAMPLES, energy_distance, fingerprint, swap_p
from analysis.stats.variance import CONFOUNDED, NEGATIVE, variance_split
from foundry.seeding import stream
from signature_tables import MEASURE, runs, table, table_of

NAMES = ["x.one", "x.two", "x.three"]


def two_alike_one_other(seeds: int = 8) -> np.ndarray:
    """Return three models of which the first two are alike (3, seeds, 3)."""
    noise = np.random.default_rng(4).normal(0, 0.1, size=(3, seeds, 3))
    return noise + np.array([0.0, 0.05, 3.0])[:, None, None]


def test_models_that_are_alike_merge_first_and_always_by_measures_without_a_unit():
    found = fingerprint(table_of(two_alike_one_other(), NAMES), measures=NAMES)
    assert found.linkage is not None
    assert set(found.linkage[0, :2].tolist()) == {0, 1}
    assert found.support.tolist() == [1.0, 1.0]
    assert (found.levels, found.measures, found.seeds) == (("a", "b", "c"), tuple(NAMES), tuple(range(8)))
    values = two_alike_one_other()
    found, scaled = (fingerprint(table_of(values * k, NAMES), measures=NAMES) for k in (1, 1000))
    assert found.z.mean().tolist() == pytest.approx([0, 0, 0], abs=1e-12)
    assert found.z.to_numpy() == pytest.approx(scaled.z.to_numpy())


def test_merges_and_their_support_are_those_of_scipy_on_every_resample():
    names = [f"x.{index}" for index in range(4)]
    values = np.random.default_rng(7).normal(size=(6, 9, 4)) + np.arange(6)[:, None, None] / 4
    found = fingerprint(table_of(values, names), measures=names)
    scaled = (values - values.mean(axis=(0, 1))) / values.std(axis=(0, 1))
    merges = linkage(scaled.mean(axis=1), method="average")
    assert found.linkage == pytest.approx(merges)
    draws = stream(9, "fingerprint").integers(0, 9, size=(RESAMPLES, 9))
    again = [joined(linkage(scaled[:, draw].mean(axis=1), method="average")) for draw in draws]
    assert found.support.tolist() == pytest.approx([np.mean([one in seen for seen in again]) for one in joined(merges)])


def joined(merges: np.ndarray) -> list[frozenset[int]]:
    held = [frozenset([index]) for index in range(len(merges) + 1)]
    for first, second in merges[:, :2].astype(int):
        held.append(held[first] | held[second])
    return held[len(merges) + 1 :]


def test_the_energy_test_swaps_labels_within_seeds():
    first, second = (np.random.default_rng(seed).normal(size=(6, 2)) + seed for seed in (0, 1))
    observed = energy_distance(first, second)
    swapped = []
    for swap in product([False, True], repeat=6):
        chosen = np.array(swap)[:, None]
        swapped.append(energy_distance(np.where(chosen, second, first), np.where(chosen, first, second)))
    assert swap_p(first, second) == pytest.approx(np.mean(np.array(swapped) >= observed - 1e-9))


def test_models_that_differ_are_told_apart_and_corrected_for_all_pairs():
    energy = fingerprint(table_of(two_alike_one_other(10), NAMES), measures=NAMES).energy
    p = dict(zip(zip(energy["level"], energy["reference"], strict=True), energy["p_holm"], strict=True))
    assert p["c", "a"] == pytest.approx(3 * 2 / 2**10)
    assert p["b", "a"] > 0.05
    energy = fingerprint(table_of(two_alike_one_other(5), NAMES), measures=NAMES).energy
    assert energy["p"].isna().all() and energy["statistic"].notna().all()
    assert energy["note"].unique().tolist() == ["not tested: n < 6"]


def test_neither_seeds_of_failed_runs_nor_what_is_undefined_is_compared():
    values = two_alike_one_other()
    values[1, 2, 0], values[:, :, 1] = math.nan, 0.5
    found = fingerprint(table_of(values, NAMES), measures=NAMES)
    assert found.measures == ("x.three",)
    assert dict(found.dropped) == {"x.one": "undefined in a run", "x.two": "no variation"}
    made = table_of(two_alike_one_other(), NAMES)
    made.frame.loc[3, "status"] = "failed"
    made.frame.loc[3, NAMES] = math.nan
    assert fingerprint(made, measures=NAMES).seeds == (0, 1, 2, 4, 5, 6, 7)


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


def split(made) -> pd.DataFrame:
    return variance_split(made).set_index("component")


def test_without_gaps_it_is_the_usual_analysis_of_variance_and_baselines_have_no_part_in_it():
    values = np.random.default_rng(3).normal(size=(3, 8, 1)) + np.arange(3)[:, None, None]
    frame = split(table_of(values, [MEASURE]))
    cells = values[:, :, 0]
    models, seeds = cells.mean(axis=1, keepdims=True), cells.mean(axis=0, keepdims=True)
    residual = ((cells - models - seeds + cells.mean()) ** 2).sum() / (2 * 7)
    assert frame.loc["residual", "variance"] == pytest.approx(residual)
    assert frame.loc["model", "variance"] == pytest.approx(models.var(ddof=1) - residual / 8)
    assert frame.loc["seed", "variance"] == pytest.approx(max(seeds.var(ddof=1) - residual / 3, 0))
    assert frame["share"].sum() == pytest.approx(1.0)
    own = [*runs("a", [0.1, 0.4, 0.3], baseline=False), *runs("b", [0.5, 0.6, 0.9], baseline=False)]
    beside = [*own, *runs("walker", [5, 6, 8], baseline=True)]
    pd.testing.assert_frame_equal(variance_split(table(beside)), variance_split(table(own)))


def test_the_components_that_made_the_values_are_found_in_spite_of_gaps():
    rng = np.random.default_rng(8)
    model, prompt, seed = (rng.normal(0, sd, size=10) for sd in (2, 1, 0.5))
    values = model[:, None, None] + prompt[:, None] + seed + rng.normal(0, 0.3, (10, 10, 10))
    values[rng.random(values.shape) < 0.2] = math.nan
    rows = [
        {"model": f"m{m}", "prompt": f"p{p}", "seed": s, MEASURE: value} for (m, p, s), value in np.ndenumerate(values)
    ]
    column = split(table(rows))["variance"]
    drawn = [effects.var(ddof=1) for effects in (model, prompt, seed)]
    assert column[["model", "prompt", "seed"]].tolist() == pytest.approx(drawn, rel=0.1)
    assert column["residual"] == pytest.approx(0.09, rel=0.15)


def test_a_component_below_zero_is_shown_as_zero_and_named():
    values = np.array([[1.0, -1, 1, -1], [-1, 1, -1, 1], [0, 0, 0, 0]])[:, :, None]
    frame = split(table_of(values, [MEASURE]))
    assert frame.loc[["model", "seed"], "variance"].tolist() == [0.0, 0.0]
    assert frame.loc["model", "note"] == NEGATIVE
    assert frame.loc["residual", "share"] == 1.0


def test_equal_or_undefined_values_have_no_share():
    frame = split(table_of(np.full((2, 4, 1), 0.3), [MEASURE]))
    assert frame["variance"].tolist() == [0.0, 0.0, 0.0]
    assert frame["share"].isna().all()
    assert set(frame["note"]) == {"no variation"}
    frame = split(table_of(np.full((2, 4, 1), math.nan), [MEASURE]))
    assert frame["variance"].isna().all()
    assert set(frame["note"]) == {"no value"}


def test_settings_that_change_together_or_without_a_second_seed_cannot_be_told_apart():
    rows = [*runs("a", [0.1, 0.5, 0.2], prompt="x"), *runs("b", [0.3, 0.2, 0.9], prompt="y")]
    frame = split(table(rows))
    assert frame.loc[["model", "prompt"], "note"].tolist() == [CONFOUNDED, CONFOUNDED]
    assert frame.loc["residual", "variance"] > 0
    assert frame["share"].isna().all()
    frame = split(table([*runs("a", [0.1]), *runs("b", [0.3])]))
    assert frame["variance"].isna().all()
    assert set(frame["note"]) == {CONFOUNDED}


@pytest.mark.parametrize("spread", [1e-3, 0.0])
def test_what_another_machine_rounds_otherwise_gives_the_same_table(spread: float):
    values = np.random.default_rng(5).normal(size=(3, 8, 1)) * spread + np.arange(8)[:, None]
    noise = 1 + np.random.default_rng(6).normal(size=values.shape) * 1e-15
    frame, expected = (split(table_of(made, [MEASURE])) for made in (values * noise, values))
    pd.testing.assert_frame_equal(frame, expected, check_exact=True)
