"""What the signature of certainty says of runs whose probabilities are known."""

import math

import numpy as np
import pytest

from analysis import signatures
from analysis.any.signatures import action, certainty
from blind_any_runs import any_run
from told_runs import TellingCrowd, told, told_run

DRAWN = [(1, 0, "go"), (1, 1, "stay"), (2, 0, "go"), (2, 1, "wait")]
SURE, EVEN = {"go": 0.9, "stay": 0.06, "wait": 0.04}, {"go": 0.25, "stay": 0.25, "wait": 0.5}
LOW = {"go": 0.6, "stay": 0.2, "Go": 0.2}


def test_measures_are_those_that_are_worked_out_by_hand():
    tells = [told("go", SURE), told("stay", EVEN), told("go", LOW), None]
    run = told_run(any_run(DRAWN), tells, ["go", "wait", "go", None])
    measures = certainty.measure(run)
    bits = [-sum(p * math.log2(p) for p in chances.values()) / math.log2(3) for chances in (SURE, EVEN)]
    assert measures == pytest.approx(
        {
            "probability": (0.9 + 0.25) / 2,
            "entropy": sum(bits) / 2,
            "covered": (1 + 1 + 0.8) / 3,
            "expected_go": (0.9 + 0.25) / 2,
            "expected_stay": (0.06 + 0.25) / 2,
            "expected_wait": (0.04 + 0.5) / 2,
            "beyond_draws": (0.9 - 0.8152 + 0.25 - 0.375) / 2,
            "brier": (0.01 + 0.0036 + 0.0016 + 0.0625 + 0.0625 + 0.25) / 2,
            "overconfidence": (0.9 + 0.5) / 2 - 1,
            "n_told": 2, "n_low": 1, "n_expected": 2, "n_right": 2,
        }
    )  # fmt: skip


def test_shares_that_the_settings_of_the_call_do_not_give_are_left_out_and_counted():
    run = told_run(any_run(DRAWN[:1]), [told("go", {"go": 0.7, "stay": 0.3}, temperature=1.5)])
    measures = certainty.measure(run)
    assert measures["probability"] == pytest.approx(0.7) and math.isnan(measures["expected_go"])
    assert (measures["n_told"], measures["n_expected"]) == (1, 0) and "brier" not in measures


def test_a_run_without_log_probabilities_has_no_such_measure_and_one_that_told_nothing_has_nan():
    plain = any_run(DRAWN)
    assert not [name for name in signatures.measure(plain) if name.startswith("certainty.")]
    silent = certainty.measure(told_run(plain, [None] * 4, [None] * 4))
    assert all(math.isnan(value) for name, value in silent.items() if not name.startswith("n_"))


def test_expected_shares_estimate_sampled_ones_with_less_noise():
    crowd = TellingCrowd(temperature=0.5, steps=10)
    runs = [crowd.play(seed) for seed in range(30)]
    expected = np.array([certainty.measure(run)["expected_go"] for run in runs])
    sampled = np.array([action.measure(run)["share_go"] for run in runs])
    assert abs((expected - sampled).mean()) < 3 * (expected - sampled).std() / math.sqrt(30)
    assert expected.std() < 0.8 * sampled.std()


@pytest.mark.parametrize(("temperature", "said"), [(0.5, 1.0), (1.0, 0.5)])
def test_draws_at_another_temperature_than_the_call_says_are_told(temperature: float, said: float):
    measures = certainty.measure(TellingCrowd(temperature, said).play(0))["beyond_draws"]
    assert abs(measures) > 0.05 and (measures > 0) == (temperature < said)
