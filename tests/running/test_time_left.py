from pathlib import Path

import numpy as np
import pytest
from bench_time_left import SEEDS, SIMULATED, watched, worst_ratio

FACTOR = 1.5


@pytest.mark.parametrize("seeds", [SEEDS[:1], pytest.param(SEEDS[1:], marks=pytest.mark.slow)], ids=["one", "others"])
@pytest.mark.parametrize("name", SIMULATED)
def test_the_time_left_is_right_within_a_factor_of_one_and_a_half_from_the_tenth_call_on(
    name: str, seeds: range, tmp_path: Path
):
    for seed in seeds:
        looks, took = watched(SIMULATED[name](np.random.default_rng(seed)), tmp_path / str(seed))
        worst = worst_ratio(looks, took)
        assert worst <= FACTOR, (seed, worst)
        assert looks[-1].left == 0.0
