"""How many seeds a probe needs: what the variance of its pilot is made of is known here."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest

from analysis.probes.choices import Chosen, MomentKey
from analysis.probes.distance import apart, gap
from analysis.probes.probe_power import _needed, _pilot
from analysis.stats.sign_flip import upper_sign_flip_p
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


def seeds_needed(excess: float, sd: float, level: float, *, between: float = 1.0) -> dict[str, Any]:
    """Return what a pilot of 200 normal seeds needs; `between` is the part of the variance that is between seeds."""
    normal = stream(0, "pilot").normal(size=200)
    excesses = excess + sd * (normal - normal.mean()) / normal.std(ddof=1)
    parts = {"between": between * sd**2, "by_moments": (1 - between) * sd**2, "by_repeats": 0.0}
    return _needed({"observed": excess, "sd": sd, "excesses": excesses, **parts}, None, 0.8, level)


@pytest.mark.parametrize(("effect", "level"), [(0.8, 0.05), (1.2, 0.05), (1.2, 0.05 / 7)])
def test_the_promised_seeds_give_the_promised_power_by_the_test_in_use(effect: float, level: float):
    needed = seeds_needed(0.1 * effect, 0.1, level, between=0.6)
    samples = stream(0, "power").normal(effect, size=(1_000, int(needed["n"])))
    p = upper_sign_flip_p(samples)
    assert 0.75 < (p <= level).mean() < 0.92
    assert needed["n_moments"] < needed["n"] == needed["n_repeats"]


def test_an_exact_test_needs_six_seeds_and_as_many_as_its_level_takes_signs():
    assert (seeds_needed(0.9, 0.1, 0.05)["n"], seeds_needed(0.9, 0.1, 0.05 / 7)["n"]) == (6, 8)
    assert seeds_needed(-0.1, 0.1, 0.05)["note"] == "no difference to find"
