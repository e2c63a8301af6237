"""How many seeds a probe needs: what the variance of its pilot is made of is known here."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from analysis.probes.choices import Chosen, MomentKey
from analysis.probes.distance import apart, gap
from analysis.probes.power import _needed, _pilot
from foundry.seeding import stream

SEEDS, STEPS, REPEATS = 40, 16, 8
KEYS = [MomentKey(seed, "run", step, 0, "action", 0) for seed in range(SEEDS) for step in range(STEPS)]


def drawn(chance: Callable[[MomentKey], float], name: str) -> Chosen:
    rng = stream(0, name)
    said = {key: int(rng.binomial(REPEATS, chance(key))) for key in KEYS}
    return {key: Counter({"yes": yes, "no": REPEATS - yes}) for key, yes in said.items()}


def pilot(chance: Callable[[MomentKey], float]) -> dict[str, Any]:
    return _pilot(drawn(lambda key: 0.0, "no"), drawn(chance, "yes"), "pilot")


def test_the_gap_is_the_distance_above_its_floor():
    first, second = Counter({"a": 3, "b": 5}), Counter({"a": 6, "c": 1})
    found = apart(first, second, stream(0, "t"))
    assert gap(first, second) == pytest.approx(found.distance - found.floor)


@pytest.mark.slow
def test_what_repeats_draw_is_told_from_what_moments_and_seeds_differ_in():
    draws = pilot(lambda key: 0.5)
    assert draws["by_repeats"] > 0.5 * draws["sd"] ** 2 and draws["between"] < 0.2 * draws["sd"] ** 2
    moments = pilot(lambda key: float(key.step % 2))
    assert moments["sd"] == 0 and moments["repeats"] == REPEATS and moments["moments"] == STEPS
    seeds = pilot(lambda key: float(key.seed % 2))
    assert seeds["between"] == pytest.approx(seeds["sd"] ** 2) and seeds["by_repeats"] == 0
    mixed = pilot(lambda key: float((7 * key.seed + 5 * key.step) % 11 < 5))
    assert mixed["by_moments"] == pytest.approx(mixed["sd"] ** 2) and mixed["by_repeats"] == 0


def test_the_parts_of_the_variance_add_up():
    found = pilot(lambda key: 0.1 + 0.02 * (key.seed % 20) + 0.03 * (key.step % 10))
    assert found["between"] > 0 and found["by_moments"] > 0 and found["by_repeats"] > 0
    assert found["between"] + found["by_moments"] + found["by_repeats"] == pytest.approx(found["sd"] ** 2)


def test_as_many_seeds_are_needed_as_find_the_difference_in_four_of_five_samples():
    one = {"observed": 0.08, "sd": 0.1, "between": 0.006, "by_moments": 0.004, "by_repeats": 0.0}
    needed = _needed(one, None, 0.8, 0.05)
    n = int(needed["n"])
    samples = stream(0, "power").normal(0.08, 0.1, size=(20_000, n))
    t = samples.mean(axis=1) / (samples.std(axis=1, ddof=1) / np.sqrt(n))
    from scipy.special import stdtrit

    power = (t > stdtrit(n - 1, 0.95)).mean()
    assert 0.79 < power < 0.86
    assert needed["n_moments"] < needed["n"] == needed["n_repeats"]


def test_an_exact_test_needs_six_seeds_and_as_many_as_its_level_takes_signs():
    one = {"observed": 0.9, "sd": 0.1, "between": 0.01, "by_moments": 0.0, "by_repeats": 0.0}
    assert (_needed(one, None, 0.8, 0.05)["n"], _needed(one, None, 0.8, 0.05 / 7)["n"]) == (6, 8)
    assert _needed({**one, "observed": -0.1}, None, 0.8, 0.05)["note"] == "no difference to find"
