"""How many seeds a probe needs: the plan of a sweep finds by the one-sided test of a probe what it promises."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from analysis.probes.differences import named
from analysis.stats.contrasts import ALPHA
from analysis.stats.power import seeds_needed
from analysis.stats.sign_flip import upper_sign_flip_p
from foundry.seeding import stream


def needed(effect: float, tests: int = 1) -> pd.Series:
    """Return the plan of a comparison by a pilot of 200 normal seeds with this excess in standard deviations."""
    normal = stream(0, "pilot").normal(size=200)
    excesses = effect + (normal - normal.mean()) / normal.std(ddof=1)
    row = named({"model": "a", "edit": "no_fire"}) | {"differences": excesses, "n_pairs": 200}
    pilot = pd.DataFrame([row | {"observed": effect, "sd": 1.0, "declared": True, "family": tests, "pairs": tests}])
    return seeds_needed(pilot, pilot["observed"].clip(lower=0), 0.8, 2 * ALPHA).iloc[0]


@pytest.mark.parametrize(("effect", "tests"), [(0.8, 1), (1.2, 1), (1.2, 7)])
def test_the_promised_seeds_give_the_promised_power_by_the_test_in_use(effect: float, tests: int):
    samples = stream(0, "power").normal(effect, size=(1_000, int(needed(effect, tests)["n_family"])))
    assert 0.75 < (upper_sign_flip_p(samples) <= ALPHA / tests).mean() < 0.92


def test_an_exact_test_needs_six_seeds_and_as_many_as_its_level_takes_signs():
    assert (needed(9.0)["n_family"], needed(9.0, 7)["n_family"]) == (6, 8)
    assert needed(-1.0)["note"] == "no difference to find" and np.isnan(needed(-1.0)["n_family"])
