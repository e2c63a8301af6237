"""Runs in which something never happens: undefined is NaN, and never 0."""

import math
from typing import Any

import numpy as np
import pytest

from analysis import signatures
from analysis.grid.grid_run import Fire
from analysis.grid.signatures import clustering, communication, hazard
from grid_runs import grid_run
from walkers import Habits

REACH = {"social_reach", "traced_reach", "oracle_reach", "rmst"}
RELAYED = {"relay_probability", "relay_above_chance", "virality"}
RATES = {"overcrowding", "utilisation", "volatility"}
SINCE = {f"{rate}_since_entry" for rate in RATES}
WAYS = {"resultant_length", "mean_direction", "share_up", "share_down", "share_left", "share_right"}
CORNER = {"name": "cafe", "type": "cafe", "center": [5, 5], "extent": [0, 0], "capacity": 1}
EVERYWHERE = {"name": "fire1", "start": 1, "position": [4, 4], "intensity": 0.8, "radius": 99}


def undefined(found: dict[str, float], signature: str) -> set[str]:
    """Return the names of a signature's measures over all decisions that are NaN."""
    return {
        key.partition(".")[2]
        for key, value in found.items()
        if key.startswith(signature) and math.isnan(value) and not signatures.is_readable_only(key)
    }


@pytest.mark.parametrize(
    ("settings", "habits", "signature", "expected"),
    [
        ({"fires": []}, {}, "warning.", {
            "informed_fraction", "normalised_reach", "reproduction", "depth", "trees", *REACH, *RELAYED,
        }),
        ({"fires": [{**EVERYWHERE, "start": 999}]}, {}, "warning.", {
            "informed_fraction", "normalised_reach", "reproduction", "depth", "trees", *REACH, *RELAYED,
        }),
        ({"fires": [EVERYWHERE]}, {}, "warning.", {*REACH, *RELAYED, "normalised_reach"}),
        ({"seed": 3}, {"speak": 0}, "warning.", {*RELAYED, "false_alarm_rate", "warning_share", "unknown"}),
        ({"agents": 1}, {}, "clustering.", set(clustering.MEASURES)),
        ({}, {"speak": 0}, "communication.", {
            "gini", "burstiness", "burstiness_finite", "reciprocity", "audience", "length", "variety", "distinct_share",
        }),
        ({}, {"move": 0, "unreadable": 0}, "movement.", {
            "walker_kl", "variety", "alignment", "direction_entropy", "direction_bits", "direction_kl",
            "asked_entropy", "asked_bits", "asked_kl", *WAYS, *(f"asked_{way}" for way in WAYS),
        }),
        ({}, {"move": 0, "unreadable": 0}, "stability.", {"kappa", "reversal_rate"}),
        ({}, {"move": 0, "unreadable": 0}, "path_efficiency.", {"trip_efficiency", "trip_efficiency_moving"}),
        ({"places": []}, {}, "place_choice.", {
            "entropy", "entropy_places", "switch_rate", "capacity_divergence", *RATES, *SINCE,
        }),
        ({"places": []}, {}, "idle_rate.", {
            "chosen_in_place", "chosen_in_crowd", "immobile_in_place", "immobile_in_crowd",
        }),
        ({"places": [CORNER], "seed": 2}, {"move": 0}, "place_choice.", {
            "first_choice_cafe", "entropy_places", "switch_rate", "capacity_divergence", *SINCE,
        }),
    ],
)  # fmt: skip
def test_what_never_happens_is_undefined(
    settings: dict[str, Any], habits: dict[str, Any], signature: str, expected: set[str], recorded
):
    found = signatures.measure(recorded(habits=Habits(**habits), **settings).run)
    assert undefined(found, signature) == expected


def test_without_fires_there_are_false_alarms_and_no_exposure(recorded):
    run = recorded(fires=[], seed=1).run
    found = signatures.measure(run)
    assert found["warning.false_alarm_rate"] > 0 and found["warning.n_direct"] == 0
    found = hazard.measure(run)
    assert {name for name, value in found.items() if not math.isnan(value)} == {
        "exposure", "n_decisions", "n_exposed", "n_exposed_moves", "n_matched", "n_controls", "n_choices",
        "n_exposed_agents",
    }  # fmt: skip
    assert found["n_exposed"] == found["exposure"] == 0


def test_who_says_and_does_nothing_reaches_nobody_and_nothing(recorded):
    found = signatures.measure(recorded(seed=3, habits=Habits(speak=0, move=0, unreadable=0)).run)
    assert found["warning.n_direct"] > 0
    assert (found["warning.social_reach"], found["warning.reproduction"], found["warning.depth"]) == (0, 0, 0)
    assert (found["communication.rate"], found["communication.silent_share"]) == (0, 1)
    assert found["idle_rate.chosen"] == found["idle_rate.immobile"] == found["stability.persistence"] == 1
    assert found["movement.drift_place"] == found["exploration.gyration"] == found["exploration.visit_entropy"] == 0
    assert found["exploration.unique_ratio"] == pytest.approx(1 / 26)


def test_agents_in_one_cell_have_an_index_of_zero_and_one_step_has_no_pairs(recorded):
    found = clustering.measure(grid_run([[(1, 1), (2, 1)]] * 3))
    assert found["nni"] == found["nni_donnelly"] == found["nni_naive"] == 0 and found["nni_z"] < -1
    found = signatures.measure(recorded(steps=1).run)
    assert {"persistence", "kappa", "conditional_entropy", "reversal_rate"} <= undefined(found, "stability.")
    assert "largest_group" in undefined(found, "clustering.")
    assert not math.isnan(found["clustering.nni_donnelly"])


def test_two_messages_have_no_rhythm():
    said = np.array([["a"], [None], ["b"], [None]], dtype=object)
    found = communication.measure(grid_run([[(0, 0)] * 5], said=said))
    assert math.isnan(found["burstiness"]) and math.isnan(found["burstiness_finite"])
    assert (found["rate"], found["n_rhythmic"]) == (0.5, 0)


def test_without_places_everyone_is_outside_and_those_that_nobody_enters_are_unused(recorded):
    found = signatures.measure(recorded(places=[]).run)
    assert (found["place_choice.share_outside"], found["path_efficiency.arrived"]) == (1, 0)
    assert math.isnan(found["movement.drift_place"])
    found = signatures.measure(recorded(places=[CORNER], habits=Habits(move=0), seed=2).run)
    assert found["place_choice.utilisation"] == found["place_choice.entropy"] == 0


def test_a_model_whose_replies_cannot_be_read_is_idle_but_chose_nothing(recorded):
    found = signatures.measure(recorded(habits=Habits(unreadable=1)).run)
    assert found["outcome.readable"] == found["idle_rate.chosen"] == 0
    assert found["idle_rate.invalid"] == found["idle_rate.immobile"] == 1
    for name in ("idle_rate.chosen", "stability.persistence", "movement.drift_place", "place_choice.entropy"):
        assert math.isnan(found[f"{name}_readable"]) and not math.isnan(found[name])
    assert found["exploration.unique_ratio_readable"] == 1, "the start alone is left"


def test_two_agents_that_cry_fire_at_each_other_make_no_cycle(recorded):
    habits = Habits(speak=1, texts=("fire!",))
    found = signatures.measure(recorded(habits=habits, communication_distance=50, places=[]).run)
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
