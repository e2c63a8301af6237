from pathlib import Path

import numpy as np
import pytest
from bench_time_left import SEEDS, SIMULATED, watched, worst_ratio

FACTOR = 1.5


@pytest.mark.parametrize("name", SIMULATED)
def test_the_time_left_is_right_within_a_factor_of_one_and_a_half_from_the_tenth_call_on(name: str, tmp_path: Path):
    looks, took = watched(SIMULATED[name](np.random.default_rng(SEEDS[0])), tmp_path / "sweep")
    assert worst_ratio(looks, took) <= FACTOR
    assert looks[-1].left == 0.0
