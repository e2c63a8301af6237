"""Runs in which something never happens: undefined is NaN, and never 0."""

from __future__ import annotations

import math

import pytest

from analysis import signatures
from foundry.records import Message


def measures(written) -> dict[str, float]:
    return signatures.measure(written.run)


def undefined(found: dict[str, float], signature: str) -> set[str]:
    """Return the names of a signature's measures that are NaN."""
    return {key.partition(".")[2] for key, value in found.items() if key.startswith(signature) and math.isnan(value)}


def test_without_fires_reach_is_undefined_and_false_alarms_are_not(recorded):
    found = measures(recorded(fires=[], seed=1))
    assert undefined(found, "warning.") == {
        "informed_fraction", "social_reach", "traced_reach", "oracle_reach", "normalised_reach",
        "relay_probability", "reproduction", "depth", "trees", "rmst",
    }  # fmt: skip
    assert found["warning.false_alarm_rate"] > 0
    assert found["warning.n_direct"] == 0


def test_a_fire_that_nobody_perceives_leaves_reach_undefined(recorded, small_world):
    late = [{**fire, "start": 999} for fire in small_world["fires"]]
    assert "social_reach" in undefined(measures(recorded(fires=late)), "warning.")


def test_a_perceived_fire_of_which_nobody_speaks_has_reach_zero(recorded, make_habits):
    found = measures(recorded(seed=3, habits=make_habits(speak=0)))
    assert found["warning.n_direct"] > 0
    assert (found["warning.social_reach"], found["warning.reproduction"], found["warning.depth"]) == (0, 0, 0)
    assert undefined(found, "warning.") == {"relay_probability", "false_alarm_rate", "warning_share"} | (
        {"normalised_reach"} if found["warning.n_reachable"] == 0 else set()
    )


def test_when_everyone_sees_the_fire_first_reach_is_undefined(recorded, small_world):
    everywhere = [{**small_world["fires"][0], "start": 1, "radius": 99}]
    found = measures(recorded(fires=everywhere))
    assert undefined(found, "warning.") >= {"social_reach", "traced_reach", "oracle_reach", "rmst"}
    assert found["warning.informed_fraction"] == 1


def test_one_agent_has_no_clustering(recorded):
    found = measures(recorded(agents=1))
    assert undefined(found, "clustering.") == {
        "nni_donnelly", "nni_naive", "largest_group", "groups", "isolated",
    }  # fmt: skip
    assert undefined(found, "communication.") >= {"conditional_rate", "reciprocity"}


def test_one_step_has_no_pairs(recorded):
    found = measures(recorded(steps=1))
    assert {"persistence", "kappa", "conditional_entropy", "reversal_rate"} <= undefined(found, "stability.")
    assert "largest_group" in undefined(found, "clustering.")
    assert not math.isnan(found["clustering.nni_donnelly"])


def test_when_nobody_talks_the_rate_is_zero_and_the_rest_undefined(recorded, make_habits):
    found = measures(recorded(habits=make_habits(speak=0)))
    assert found["communication.rate"] == 0
    assert found["communication.silent_share"] == 1
    assert undefined(found, "communication.") == {
        "gini", "burstiness", "burstiness_finite", "reciprocity", "audience", "length", "distinct_share",
    }  # fmt: skip


def test_when_nobody_moves_directions_are_undefined(recorded, make_habits):
    found = measures(recorded(habits=make_habits(move=0, unreadable=0)))
    assert undefined(found, "movement.") == {
        "direction_entropy", "direction_bits", "asked_entropy", "resultant_length",
        "share_up", "share_down", "share_left", "share_right",
    }  # fmt: skip
    assert found["idle_rate.chosen"] == found["idle_rate.immobile"] == found["stability.persistence"] == 1
    assert undefined(found, "stability.") == {"kappa", "kappa_readable", "reversal_rate"}
    assert found["exploration.unique_ratio"] == pytest.approx(1 / 26)
    assert found["exploration.visit_entropy"] == found["exploration.gyration"] == 0
    assert undefined(found, "path_efficiency.") == {"trip_efficiency", "trip_efficiency_moving"}


def test_without_places_everyone_is_outside(recorded):
    found = measures(recorded(places=[]))
    assert found["place_choice.share_outside"] == 1
    assert undefined(found, "place_choice.") == {
        "overcrowding", "utilisation", "volatility", "entropy", "entropy_places",
    }  # fmt: skip
    assert found["path_efficiency.arrived"] == 0


def test_places_that_nobody_enters_are_unused(recorded, small_world, make_habits):
    corner = [{**small_world["places"][0], "center": [5, 5], "extent": [0, 0]}]
    found = measures(recorded(places=corner, habits=make_habits(move=0), seed=2))
    assert found["place_choice.utilisation"] == found["place_choice.entropy"] == 0
    assert undefined(found, "place_choice.") == {"first_choice_cafe", "entropy_places"}


def test_a_model_whose_replies_cannot_be_read_is_idle_but_chose_nothing(recorded, make_habits):
    found = measures(recorded(habits=make_habits(unreadable=1)))
    assert found["outcome.readable"] == found["idle_rate.chosen"] == 0
    assert found["idle_rate.invalid"] == found["idle_rate.immobile"] == 1
    assert math.isnan(found["idle_rate.chosen_readable"])
    assert math.isnan(found["stability.persistence_readable"])


def test_two_agents_that_cry_fire_at_each_other_make_no_cycle(recorded, make_habits):
    habits = make_habits(speak=1, texts=("fire!",))
    found = measures(recorded(habits=habits, communication_distance=50, places=[]))
    assert found["warning.depth"] == found["warning.reproduction"] == 0
    assert found["warning.social_reach"] == 1
    assert found["warning.traced_reach"] < 1 or found["warning.n_direct"] == 0


def test_a_false_alarm_is_told_but_not_traced(recorded, make_habits):
    written = recorded(seed=4, habits=make_habits(speak=0.5, texts=("fire!",)))
    found = measures(written)
    assert found["warning.traced_reach"] <= found["warning.social_reach"]
    assert found["warning.traced_reach"] <= found["warning.oracle_reach"]


def test_deliveries_count_by_recipient(recorded):
    written = recorded(seed=7)
    found = measures(written)
    assert all(isinstance(message, Message) for message in written.walk.messages)
    assert found["communication.n_deliveries"] == len(written.walk.messages)
