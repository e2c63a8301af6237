"""Variance components."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from analysis.stats.variance import CONFOUNDED, NEGATIVE, variance_split
from signature_tables import MEASURE, runs, table, table_of


def split(made) -> pd.DataFrame:
    return variance_split(made).set_index("component")


def test_without_gaps_it_is_the_usual_analysis_of_variance():
    values = np.random.default_rng(3).normal(size=(3, 8, 1)) + np.arange(3)[:, None, None]
    found = split(table_of(values, [MEASURE]))
    cells = values[:, :, 0]
    models, seeds = cells.mean(axis=1, keepdims=True), cells.mean(axis=0, keepdims=True)
    residual = ((cells - models - seeds + cells.mean()) ** 2).sum() / (2 * 7)
    assert found.loc["residual", "variance"] == pytest.approx(residual)
    assert found.loc["model", "variance"] == pytest.approx(models.var(ddof=1) - residual / 8)
    assert found.loc["seed", "variance"] == pytest.approx(max(seeds.var(ddof=1) - residual / 3, 0))
    assert found["share"].sum() == pytest.approx(1.0)


def test_the_components_that_made_the_values_are_found_in_spite_of_gaps():
    rng = np.random.default_rng(8)
    model, prompt, seed = (rng.normal(0, sd, size=10) for sd in (2, 1, 0.5))
    values = model[:, None, None] + prompt[:, None] + seed + rng.normal(0, 0.3, (10, 10, 10))
    values[rng.random(values.shape) < 0.2] = math.nan
    rows = [
        {"model": f"m{m}", "prompt": f"p{p}", "seed": s, MEASURE: value} for (m, p, s), value in np.ndenumerate(values)
    ]
    found = split(table(rows))["variance"]
    drawn = [effects.var(ddof=1) for effects in (model, prompt, seed)]
    assert found[["model", "prompt", "seed"]].tolist() == pytest.approx(drawn, rel=0.1)
    assert found["residual"] == pytest.approx(0.09, rel=0.15)


def test_a_component_below_zero_is_shown_as_zero_and_named():
    values = np.array([[1.0, -1, 1, -1], [-1, 1, -1, 1], [0, 0, 0, 0]])[:, :, None]
    found = split(table_of(values, [MEASURE]))
    assert found.loc[["model", "seed"], "variance"].tolist() == [0.0, 0.0]
    assert found.loc["model", "note"] == NEGATIVE
    assert found.loc["residual", "share"] == 1.0


def test_equal_or_undefined_values_have_no_share():
    found = split(table_of(np.full((2, 4, 1), 0.3), [MEASURE]))
    assert found["variance"].tolist() == [0.0, 0.0, 0.0]
    assert found["share"].isna().all()
    assert set(found["note"]) == {"no variation"}
    found = split(table_of(np.full((2, 4, 1), math.nan), [MEASURE]))
    assert found["variance"].isna().all()
    assert set(found["note"]) == {"no value"}


def test_settings_that_change_together_cannot_be_told_apart():
    rows = [*runs("a", [0.1, 0.5, 0.2], prompt="x"), *runs("b", [0.3, 0.2, 0.9], prompt="y")]
    found = split(table(rows))
    assert found.loc[["model", "prompt"], "note"].tolist() == [CONFOUNDED, CONFOUNDED]
    assert found.loc["residual", "variance"] > 0
    assert found["share"].isna().all()


def test_one_seed_leaves_no_residual():
    found = split(table([*runs("a", [0.1]), *runs("b", [0.3])]))
    assert found["variance"].isna().all()
    assert set(found["note"]) == {CONFOUNDED}


def test_baselines_have_no_part_in_it():
    own = [*runs("a", [0.1, 0.4, 0.3], baseline=False), *runs("b", [0.5, 0.6, 0.9], baseline=False)]
    expected = variance_split(table(own))
    found = variance_split(table([*own, *runs("walker", [5, 6, 8], baseline=True)]))
    pd.testing.assert_frame_equal(found, expected)


@pytest.mark.parametrize("spread", [1e-3, 0.0])
def test_what_another_machine_rounds_otherwise_gives_the_same_table(spread: float):
    values = np.random.default_rng(5).normal(size=(3, 8, 1)) * spread + np.arange(8)[:, None]
    noise = 1 + np.random.default_rng(6).normal(size=values.shape) * 1e-15
    found, expected = (split(table_of(made, [MEASURE])) for made in (values * noise, values))
    pd.testing.assert_frame_equal(found, expected, check_exact=True)
