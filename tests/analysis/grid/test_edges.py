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
    measures = signatures.measure(recorded(habits=Habits(**habits), **settings).run)
    assert undefined(measures, signature) == expected


def test_without_fires_there_are_false_alarms_and_no_exposure(recorded):
    run = recorded(fires=[], seed=1).run
    measures = signatures.measure(run)
    assert measures["warning.false_alarm_rate"] > 0 and measures["warning.n_direct"] == 0
    measures = hazard.measure(run)
    assert {name for name, value in measures.items() if not math.isnan(value)} == {
        "exposure", "n_decisions", "n_exposed", "n_exposed_moves", "n_matched", "n_controls", "n_choices",
        "n_exposed_agents",
    }  # fmt: skip
    assert measures["n_exposed"] == measures["exposure"] == 0


def test_who_says_and_does_nothing_reaches_nobody_and_nothing(recorded):
    measures = signatures.measure(recorded(seed=3, habits=Habits(speak=0, move=0, unreadable=0)).run)
    assert measures["warning.n_direct"] > 0
    assert (measures["warning.social_reach"], measures["warning.reproduction"], measures["warning.depth"]) == (0, 0, 0)
    assert (measures["communication.rate"], measures["communication.silent_share"]) == (0, 1)
    assert measures["idle_rate.chosen"] == measures["idle_rate.immobile"] == measures["stability.persistence"] == 1
    assert (
        measures["movement.drift_place"]
        == measures["exploration.gyration"]
        == measures["exploration.visit_entropy"]
        == 0
    )
    assert measures["exploration.unique_ratio"] == pytest.approx(1 / 26)


def test_agents_in_one_cell_have_an_index_of_zero_and_one_step_has_no_pairs(recorded):
    measures = clustering.measure(grid_run([[(1, 1), (2, 1)]] * 3))
    assert measures["nni"] == measures["nni_donnelly"] == measures["nni_naive"] == 0 and measures["nni_z"] < -1
    measures = signatures.measure(recorded(steps=1).run)
    assert {"persistence", "kappa", "conditional_entropy", "reversal_rate"} <= undefined(measures, "stability.")
    assert "largest_group" in undefined(measures, "clustering.")
    assert not math.isnan(measures["clustering.nni_donnelly"])


def test_two_messages_have_no_rhythm():
    said = np.array([["a"], [None], ["b"], [None]], dtype=object)
    measures = communication.measure(grid_run([[(0, 0)] * 5], said=said))
    assert math.isnan(measures["burstiness"]) and math.isnan(measures["burstiness_finite"])
    assert (measures["rate"], measures["n_rhythmic"]) == (0.5, 0)


def test_without_places_everyone_is_outside_and_those_that_nobody_enters_are_unused(recorded):
    measures = signatures.measure(recorded(places=[]).run)
    assert (measures["place_choice.share_outside"], measures["path_efficiency.arrived"]) == (1, 0)
    assert math.isnan(measures["movement.drift_place"])
    measures = signatures.measure(recorded(places=[CORNER], habits=Habits(move=0), seed=2).run)
    assert measures["place_choice.utilisation"] == measures["place_choice.entropy"] == 0


def test_a_model_whose_replies_cannot_be_read_is_idle_but_chose_nothing(recorded):
    measures = signatures.measure(recorded(habits=Habits(unreadable=1)).run)
    assert measures["outcome.readable"] == measures["idle_rate.chosen"] == 0
    assert measures["idle_rate.invalid"] == measures["idle_rate.immobile"] == 1
    for name in ("idle_rate.chosen", "stability.persistence", "movement.drift_place", "place_choice.entropy"):
        assert math.isnan(measures[f"{name}_readable"]) and not math.isnan(measures[name])
    assert measures["exploration.unique_ratio_readable"] == 1, "the start alone is left"


def test_two_agents_that_cry_fire_at_each_other_make_no_cycle(recorded):
    habits = Habits(speak=1, texts=("fire!",))
    measures = signatures.measure(recorded(habits=habits, communication_distance=50, places=[]).run)
    assert measures["warning.depth"] == measures["warning.reproduction"] == 0
    assert measures["warning.social_reach"] == 1
    assert measures["warning.traced_reach"] < 1 or measures["warning.n_direct"] == 0


def test_without_a_choice_or_a_control_there_is_no_pull():
    seen = np.ones((2, 1, 1), dtype=np.bool_)
    measures = hazard.measure(grid_run([[(1, 0), (2, 0), (3, 0)]], fires=[Fire("f", 1, (0, 0), 9.0)], fires_seen=seen))
    assert math.isnan(measures["difference_matched"]) and math.isnan(measures["log_odds_ratio"])
    assert (measures["n_matched"], measures["away"], measures["walker_away"]) == (0, 1, 0.75)
    assert measures["latency"] == 1
    path = [(step % 2 + 1, 0) for step in range(30)]
    for steps, defined in ((29, False), (30, True)):
        seen = np.ones((steps, 1, 1), dtype=np.bool_)
        run = grid_run([(path + path)[: steps + 1]], fires=[Fire("f", 1, (0, 0), 9.0)], fires_seen=seen)
        measures = hazard.measure(run)
        assert (measures["n_choices"], not math.isnan(measures["beta_fire"])) == (steps, defined)
        assert math.isnan(measures["beta_place"]) and math.isnan(measures["beta_agent"])
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
    measures = hazard.measure(grid_run(paths, fires=fires, fires_seen=seen))
    # Of each step before the start, both agents; the first agent sees the fire in the last step alone.
    assert measures["n_controls"] == 2 * controls
    assert measures["difference_matched"] == pytest.approx(1 if controls else math.nan, nan_ok=True)


def test_a_world_of_one_cell_allows_no_move():
    measures = signatures.measure(grid_run([[(0, 0)] * 4] * 2, half_size=0))
    assert measures["exploration.coverage"] == measures["exploration.walker_ratio"] == 1
    assert math.isnan(measures["movement.walker_share_up"]) and math.isnan(measures["exploration.visit_entropy"])
    assert measures["clustering.nni"] != measures["clustering.nni"], "everyone is always in one cell, at random too"
