"""How far apart two samples of choices are, by hand and against chance, and how many seeds a probe needs."""

import itertools
from collections import Counter

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.probes.choices import Change, MomentKey
from analysis.probes.comparing import Compared
from analysis.probes.differences import named
from analysis.probes.distance import ChoiceDistance, apart
from analysis.stats.contrasts import ALPHA
from analysis.stats.power import seeds_needed
from analysis.stats.sign_flip import upper_sign_flip_p
from foundry.seeding import stream

samples = st.lists(st.sampled_from("abc"), min_size=1, max_size=4)


@given(samples, samples)
def test_the_floor_is_the_mean_over_all_splits(first: list[str], second: list[str]):
    pooled = [*first, *second]
    gaps = []
    for taken in itertools.combinations(range(len(pooled)), len(first)):
        one = Counter(pooled[place] for place in taken)
        other = Counter(pooled) - one
        gaps.append(0.5 * sum(abs(one[k] / len(first) - other[k] / len(second)) for k in set(pooled)))
    found = apart(Counter(first), Counter(second), stream(0, "test"))
    assert found.floor == pytest.approx(np.mean(gaps))
    assert found.p == pytest.approx(np.mean([gap >= found.distance - 1e-9 for gap in gaps]), abs=0.08)


def test_only_samples_that_differ_beyond_one_answer_are_apart_and_a_mirror_expects_the_other_side():
    assert apart(Counter(left=10), Counter(right=10), stream(0, "test")).distance == 1
    same = apart(Counter(left=5, right=5), Counter(left=5, right=5), stream(0, "test"))
    assert (same.distance, same.p) == (0, 1) and same.floor > 0.1
    for other in ("left", "right"):
        found = apart(Counter(left=1), Counter({other: 1}), stream(0, "test"))
        assert found.distance == found.floor and found.p == 1
    change = Change("mirror", "equivariance", {"left": "right", "right": "left"})
    assert change.carried(Counter(left=3, stay=1)) == Counter(right=3, stay=1)


def sampled(rng: np.random.Generator, chance: np.ndarray, repeats: int) -> Counter[str]:
    return Counter(dict(zip("abcde", rng.multinomial(repeats, chance).tolist(), strict=True)))


@pytest.mark.slow
def test_one_model_under_two_names_is_told_apart_from_itself_no_more_often_than_declared():
    rng = stream(0, "null")
    found = 0
    for _ in range(200):
        chances = [rng.dirichlet(np.ones(5)) for _ in range(18)]
        keys = [MomentKey(number % 6, "run", number, 0, "action", 0) for number in range(18)]
        one, other = ({key: sampled(rng, p, 5) for key, p in zip(keys, chances, strict=True)} for _ in range(2))
        excess = np.array([gap.distance - gap.floor for gap in Compared.of(one, other, "null").moments.values()])
        found += bool(upper_sign_flip_p(excess.reshape(3, 6).mean(axis=0)[None, :])[0] <= 0.05)
    assert found / 200 <= 0.08


def test_the_one_sided_p_counts_the_signs_of_all_seeds():
    assert upper_sign_flip_p(np.array([[1.0, 2.0, 3.0], [-1.0, -2.0, -3.0], [0.0, 0.0, 0.0]])).tolist() == [1 / 8, 1, 1]
    assert upper_sign_flip_p(np.array([[3.0, -1.0]])).tolist() == [0.5]
    many = upper_sign_flip_p(np.ones((1, 20)))
    assert many[0] < 0.001
    with pytest.raises(ValueError, match="NaN"):
        upper_sign_flip_p(np.array([[np.nan]]))


@pytest.mark.parametrize("seeds", [6, 9, 30])
def test_the_interval_of_an_excess_excludes_0_exactly_where_its_p_is_at_most_5_percent(seeds: int):
    drawn = stream(seeds, "excess").exponential(0.1, seeds)
    keys = [MomentKey(seed, "run", 1, 0, "action", 0) for seed in range(seeds)]
    rows = [
        Compared({key: ChoiceDistance(value, shift, 1.0) for key, value in zip(keys, drawn, strict=True)}).rows()[0]
        for shift in np.linspace(0.0, 0.14, 60).tolist()
    ]
    excludes = [row["excess_low"] > 0 for row in rows]
    assert excludes == [row["p"] <= 0.05 for row in rows] and 0 < sum(excludes) < 60


def needed(effect: float, tests: int = 1) -> pd.Series:
    """Return the plan of a comparison by a pilot of 200 normal seeds with this excess in standard deviations."""
    normal = stream(0, "pilot").normal(size=200)
    excesses = effect + (normal - normal.mean()) / normal.std(ddof=1)
    row = named({"model": "a", "edit": "no_fire"}) | {"differences": excesses, "n_pairs": 200}
    pilot = pd.DataFrame([row | {"observed": effect, "sd": 1.0, "declared": True, "family": tests, "pairs": tests}])
    return seeds_needed(pilot, pilot["observed"].clip(lower=0), 0.8, 2 * ALPHA).iloc[0]


@pytest.mark.parametrize(("effect", "tests"), [(0.8, 1), (1.2, 7)])
def test_the_promised_seeds_give_the_promised_power_by_the_test_in_use(effect: float, tests: int):
    samples = stream(0, "power").normal(effect, size=(1_000, int(needed(effect, tests)["n_family"])))
    assert 0.75 < (upper_sign_flip_p(samples) <= ALPHA / tests).mean() < 0.92


def test_an_exact_test_needs_six_seeds_and_as_many_as_its_level_takes_signs():
    assert (needed(9.0)["n_family"], needed(9.0, 7)["n_family"]) == (6, 8)
    assert needed(-1.0)["note"] == "no difference to find" and np.isnan(needed(-1.0)["n_family"])
