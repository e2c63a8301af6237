"""Runs in which something never happens: undefined is NaN, and never 0."""

from __future__ import annotations

import math

import numpy as np
import pytest

from analysis import signatures
from analysis.grid.grid_run import Fire
from analysis.grid.signatures import clustering, communication, hazard
from grid_runs import grid_run


def measures(written) -> dict[str, float]:
    return signatures.measure(written.run)


def undefined(found: dict[str, float], signature: str) -> set[str]:
    """Return the names of a signature's measures over all decisions that are NaN."""
    return {
        key.partition(".")[2]
        for key, value in found.items()
        if key.startswith(signature) and math.isnan(value) and not signatures.is_readable_only(key)
    }


def test_without_fires_reach_and_sensitivity_are_undefined_and_false_alarms_are_not(recorded):
    found = measures(recorded(fires=[], seed=1))
    assert undefined(found, "warning.") == {
        "informed_fraction", "social_reach", "traced_reach", "oracle_reach", "normalised_reach",
        "relay_probability", "relay_above_chance", "reproduction", "depth", "trees", "virality", "rmst",
    }  # fmt: skip
    assert found["warning.false_alarm_rate"] > 0
    assert found["warning.n_direct"] == 0
    found = hazard.measure(recorded(fires=[]).run)
    assert {name for name, value in found.items() if not math.isnan(value)} == {
        "exposure", "n_decisions", "n_exposed", "n_exposed_moves", "n_matched", "n_controls", "n_choices",
        "n_exposed_agents",
    }  # fmt: skip
    assert found["n_exposed"] == found["exposure"] == 0


def test_a_fire_that_nobody_perceives_leaves_reach_undefined(recorded, small_world):
    late = [{**fire, "start": 999} for fire in small_world["fires"]]
    assert "social_reach" in undefined(measures(recorded(fires=late)), "warning.")


def test_a_perceived_fire_of_which_nobody_speaks_has_reach_zero(recorded, make_habits):
    found = measures(recorded(seed=3, habits=make_habits(speak=0)))
    assert found["warning.n_direct"] > 0
    assert (found["warning.social_reach"], found["warning.reproduction"], found["warning.depth"]) == (0, 0, 0)
    assert undefined(found, "warning.") == {
        "relay_probability",
        "relay_above_chance",
        "virality",
        "false_alarm_rate",
        "warning_share",
        "unknown",
    } | (  # fmt: skip
        {"normalised_reach"} if found["warning.n_reachable"] == 0 else set()
    )


def test_when_everyone_sees_the_fire_first_reach_is_undefined(recorded, small_world):
    everywhere = [{**small_world["fires"][0], "start": 1, "radius": 99}]
    found = measures(recorded(fires=everywhere))
    assert undefined(found, "warning.") >= {"social_reach", "traced_reach", "oracle_reach", "rmst"}
    assert found["warning.informed_fraction"] == 1


def test_one_agent_has_no_clustering_and_agents_in_one_cell_have_an_index_of_zero(recorded):
    found = measures(recorded(agents=1))
    assert undefined(found, "clustering.") == set(clustering.MEASURES)
    assert undefined(found, "communication.") >= {"conditional_rate", "reciprocity"}
    found = clustering.measure(grid_run([[(1, 1), (2, 1)]] * 3))
    assert found["nni"] == found["nni_donnelly"] == found["nni_naive"] == 0
    assert found["nni_z"] < -1


def test_one_step_has_no_pairs(recorded):
    found = measures(recorded(steps=1))
    assert {"persistence", "kappa", "conditional_entropy", "reversal_rate"} <= undefined(found, "stability.")
    assert "largest_group" in undefined(found, "clustering.")
    assert not math.isnan(found["clustering.nni_donnelly"])


def test_when_nobody_talks_the_rate_is_zero_and_two_messages_have_no_rhythm(recorded, make_habits):
    found = measures(recorded(habits=make_habits(speak=0)))
    assert found["communication.rate"] == 0
    assert found["communication.silent_share"] == 1
    assert undefined(found, "communication.") == {
        "gini", "burstiness", "burstiness_finite", "reciprocity", "audience", "length", "variety", "distinct_share",
    }  # fmt: skip
    said = np.array([["a"], [None], ["b"], [None]], dtype=object)
    found = communication.measure(grid_run([[(0, 0)] * 5], said=said))
    assert math.isnan(found["burstiness"]) and math.isnan(found["burstiness_finite"])
    assert (found["rate"], found["n_rhythmic"]) == (0.5, 0)


def test_when_nobody_moves_directions_are_undefined(recorded, make_habits):
    found = measures(recorded(habits=make_habits(move=0, unreadable=0)))
    assert undefined(found, "movement.") == {"walker_kl", "variety", "alignment"} | {
        prefix + name
        for prefix, kinds in (("", ("direction_entropy", "direction_bits", "direction_kl")),
                              ("asked_", ("entropy", "bits", "kl")))
        for name in (*kinds, "resultant_length", "mean_direction",
                     "share_up", "share_down", "share_left", "share_right")
    }  # fmt: skip
    assert found["movement.drift_place"] == 0
    assert found["idle_rate.chosen"] == found["idle_rate.immobile"] == found["stability.persistence"] == 1
    assert undefined(found, "stability.") == {"kappa", "reversal_rate"}
    assert found["exploration.unique_ratio"] == pytest.approx(1 / 26)
    assert found["exploration.visit_entropy"] == found["exploration.gyration"] == 0
    assert undefined(found, "path_efficiency.") == {"trip_efficiency", "trip_efficiency_moving"}


def test_without_places_everyone_is_outside(recorded):
    found = measures(recorded(places=[]))
    assert found["place_choice.share_outside"] == 1
    assert undefined(found, "place_choice.") == {
        "overcrowding", "utilisation", "volatility", "entropy", "entropy_places", "switch_rate",
        "overcrowding_since_entry", "utilisation_since_entry", "volatility_since_entry", "capacity_divergence",
    }  # fmt: skip
    assert undefined(found, "idle_rate.") == {
        "chosen_in_place", "chosen_in_crowd", "immobile_in_place", "immobile_in_crowd",
    }  # fmt: skip
    assert math.isnan(found["movement.drift_place"])
    assert found["path_efficiency.arrived"] == 0


def test_places_that_nobody_enters_are_unused(recorded, small_world, make_habits):
    corner = [{**small_world["places"][0], "center": [5, 5], "extent": [0, 0]}]
    found = measures(recorded(places=corner, habits=make_habits(move=0), seed=2))
    assert found["place_choice.utilisation"] == found["place_choice.entropy"] == 0
    assert undefined(found, "place_choice.") == {
        "first_choice_cafe", "entropy_places", "switch_rate", "capacity_divergence",
        "overcrowding_since_entry", "utilisation_since_entry", "volatility_since_entry",
    }  # fmt: skip


def test_a_model_whose_replies_cannot_be_read_is_idle_but_chose_nothing(recorded, make_habits):
    found = measures(recorded(habits=make_habits(unreadable=1)))
    assert found["outcome.readable"] == found["idle_rate.chosen"] == 0
    assert found["idle_rate.invalid"] == found["idle_rate.immobile"] == 1
    assert math.isnan(found["idle_rate.chosen_readable"])
    for name in ("stability.persistence", "movement.drift_place", "place_choice.entropy", "clustering.nni"):
        assert math.isnan(found[f"{name}_readable"])
        assert not math.isnan(found[name])
    assert found["exploration.unique_ratio_readable"] == 1, "the start alone is left"


def test_two_agents_that_cry_fire_at_each_other_make_no_cycle(recorded, make_habits):
    habits = make_habits(speak=1, texts=("fire!",))
    found = measures(recorded(habits=habits, communication_distance=50, places=[]))
    assert found["warning.depth"] == found["warning.reproduction"] == 0
    assert found["warning.social_reach"] == 1
    assert found["warning.traced_reach"] < 1 or found["warning.n_direct"] == 0


def test_without_a_choice_or_a_control_there_is_no_pull():
    seen = np.ones((2, 1, 1), dtype=np.bool_)
    found = hazard.measure(grid_run([[(1, 0), (2, 0), (3, 0)]], fires=[Fire("f", 1, (0, 0), 9.0)], fires_seen=seen))
    assert math.isnan(found["difference_matched"]) and math.isnan(found["log_odds_ratio"])
    assert (found["n_matched"], found["away"], found["walker_away"]) == (0, 1, 0.75)
    assert found["latency"] == 1
    path = [(step % 2 + 1, 0) for step in range(30)]
    for steps, defined in ((29, False), (30, True)):
        seen = np.ones((steps, 1, 1), dtype=np.bool_)
        run = grid_run([(path + path)[: steps + 1]], fires=[Fire("f", 1, (0, 0), 9.0)], fires_seen=seen)
        found = hazard.measure(run)
        assert (found["n_choices"], not math.isnan(found["beta_fire"])) == (steps, defined)
        assert math.isnan(found["beta_place"]) and math.isnan(found["beta_agent"])
    path = [(step % 2 + 1, 0) for step in range(31)]
    seen, present = np.ones((30, 2, 1), dtype=np.bool_), np.tile([True, False], (30, 1))
    fires = [Fire("f", 1, (0, 0), 9.0)]
    alone, beside = (
        hazard.measure(grid_run([path, [(0, 5)] * 31], fires=fires, fires_seen=seen & there[..., None], present=there))
        for there in (present, np.ones_like(present))
    )
    assert math.isnan(alone["beta_agent"]) and not math.isnan(beside["beta_agent"])


@pytest.mark.parametrize(("start", "controls"), [(1, 0), (2, 1), (3, 2)])
def test_controls_are_the_decisions_before_the_step_in_which_the_fire_begins_to_burn(start: int, controls: int):
    # All are two cells and a bit less than three away; the second one is just too far to see the fire. What the third
    # one does is no control, since it sees another fire.
    paths = [[(2, 0)] * 3 + [(3, 0)], [(2, 1)] * 4, [(1, 2)] * 4]
    seen = np.zeros((3, 3, 2), dtype=np.bool_)
    seen[2, 0, 0] = seen[:, 2, 1] = True
    fires = [Fire("f", start, (0, 0), 2.0), Fire("g", 1, (1, 9), 9.0)]
    found = hazard.measure(grid_run(paths, fires=fires, fires_seen=seen))
    # Of each step before the start, both agents; the first agent sees the fire in the last step alone.
    assert found["n_controls"] == 2 * controls
    assert found["difference_matched"] == pytest.approx(1 if controls else math.nan, nan_ok=True)


def test_a_world_of_one_cell_allows_no_move():
    found = signatures.measure(grid_run([[(0, 0)] * 4] * 2, half_size=0))
    assert found["exploration.coverage"] == found["exploration.walker_ratio"] == 1
    assert math.isnan(found["movement.walker_share_up"]) and math.isnan(found["exploration.visit_entropy"])
    assert found["clustering.nni"] != found["clustering.nni"], "everyone is always in one cell, at random too"


def test_states_after_unreadable_decisions_do_not_count_as_readable():
    outcomes = np.array([[0], [2], [2], [0]])
    run = grid_run([[(0, 0), (1, 0), (1, 0), (1, 0), (1, 0)]], outcome=outcomes).only_readable()
    found = signatures.measure(run)
    assert found["exploration.n_states"] == 3, "the start and two decisions"
    assert found["exploration.unique_ratio"] == pytest.approx(2 / 3)
    assert (found["idle_rate.chosen"], found["idle_rate.longest_run"], found["movement.n_moves"]) == (0.5, 1, 1)
    assert (found["stability.n_pairs"], found["place_choice.n_states"]) == (0, 2)
