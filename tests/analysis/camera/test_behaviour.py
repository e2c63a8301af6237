"""Policies whose behaviour is known, in whole runs of a shipped world."""

from __future__ import annotations

import math

import pytest

from analysis import signatures
from whole_runs import whole_run

pytestmark = pytest.mark.slow
Measures = dict[str, float]


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """Return a function that plays a policy once and gives the measures of its run."""
    known: dict[str, Measures] = {}

    def play(policy: str, steps: int = 8) -> Measures:
        if policy not in known:
            path = tmp_path_factory.mktemp(policy) / "sweep"
            known[policy] = signatures.measure(whole_run(path, "kibo", policy, f"world.steps={steps}", seed=0))
        return known[policy]

    return play


@pytest.mark.slow
def test_the_oracle_walks_the_shortest_way_and_stops_there(played):
    found = played("oracle", 30)
    expected = {"success": 1, "reached": 1, "oracle_success": 1, "spl": 1, "oracle_spl": 1}
    assert {name: found[f"path_efficiency.{name}"] for name in expected} == pytest.approx(expected, abs=1e-6)
    assert found["path_efficiency.soft_spl"] > 0.6  # it stops within the radius
    assert found["path_efficiency.ndtw"] > 0.9
    assert (found["recovery.n_detours"], found["recovery.wrong_rate"]) == (0, 0)
    assert math.isnan(found["recovery.rmst"])
    assert abs(found["recovery.detour_cost"]) < 0.05
    assert found["collision.rate"] == 0
    assert found["recognition.false_stop"] == 0


def test_who_stays_is_idle_and_gets_nowhere(played):
    found = played("stay")
    assert found["idle_rate.chosen"] == found["idle_rate.immobile"] == found["stability.persistence"] == 1
    assert (found["turning.rate"], found["gaze.rate"], found["path_efficiency.path_length"]) == (0, 0, 0)
    assert found["path_efficiency.success"] == found["path_efficiency.spl"] == found["path_efficiency.soft_spl"] == 0
    assert math.isnan(found["path_efficiency.straightness"])
    assert (found["viewpoint.same_view_change"], found["viewpoint.n_other_pairs"]) == (0, 0)


def test_who_spins_turns_left_whatever_it_sees_and_says_nothing_of_it(played):
    found = played("spin")
    assert (found["turning.rate"], found["turning.share"], found["turning.left_bias"]) == (45, 1, 1)
    assert found["path_efficiency.path_length"] == found["idle_rate.chosen"] == 0
    assert found["viewpoint.n_other_pairs"] > 0
    assert found["viewpoint.view_change"] == found["viewpoint.bearing_information"] == 0
    assert found["stability.run_length"] == 8
    assert math.isnan(found["stability.kappa"])
    assert found["recovery.wrong_rate"] == 0  # turning is never wrong
    found = played("spin")
    assert found["recognition.mentions"] == found["recognition.chair_s"] == found["recognition.claim_rate"] == 0
    assert math.isnan(found["recognition.chair_i"])
    assert found["recognition.object_miss_rate"] == 1
