"""The formulas against worked examples that were checked with independent libraries."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from analysis.formulas import entropy, longest_run, normalised_entropy, run_lengths
from analysis.intervals import estimate
from analysis.run import CHOICES, STAY
from analysis.signatures import (
    clustering,
    communication,
    exploration,
    idle_rate,
    movement,
    place_choice,
    stability,
)
from analysis.signatures import warning as propagation

EXAMPLES = json.loads(Path(__file__).with_name("worked_examples.json").read_text(encoding="utf-8"))
COMPASS = {"N": "up", "S": "down", "W": "left", "E": "right"}


def example(name: str):
    return EXAMPLES[name]["inputs"], EXAMPLES[name]["expected"]


def close(expected: object) -> object:
    return pytest.approx(expected, abs=1e-9, rel=1e-9)


def choices(actions: list[str]) -> np.ndarray:
    return np.array([STAY if one == "stay" else CHOICES.index(COMPASS[one]) for one in actions])


@pytest.mark.parametrize(("name", "corrected"), [("nni_clark_evans_naive", False), ("nni_donnelly", True)])
def test_nearest_neighbour_indices(name: str, corrected: bool):
    inputs, expected = example(name)
    x, y = np.array(inputs["points"]).T
    left, right, bottom, top = inputs["window"]
    random = clustering.expected_distance(len(x), right - left, top - bottom, corrected=corrected)
    assert clustering.nearest_distances(x, y).mean() / random == close(expected)


def test_proximity_groups():
    inputs, expected = example("proximity_components")
    points = inputs["points"]
    near = [
        (1, i, j)
        for i, a in enumerate(points)
        for j, b in enumerate(points)
        if i != j and math.dist(a, b) <= inputs["radius"]
    ]
    shape = clustering.group_shape(np.array(near), steps=1, agents=len(points))
    assert shape[0].tolist() == close(
        [expected["largest_fraction"], expected["n_groups_ge2"], expected["isolated_fraction"]]
    )


def test_a_warning_cascade():
    inputs, expected = example("warning_cascade")
    perceived = np.full(inputs["n_agents"], propagation.NEVER)
    for agent, step in inputs["perceived"].items():
        perceived[int(agent)] = step
    warned = np.zeros((inputs["T"], inputs["n_agents"]), dtype=bool)
    for step, sender, _ in inputs["warnings"]:
        warned[step - 1, sender] = True
    heard = np.array([(step, sender, one) for step, sender, receivers in inputs["warnings"] for one in receivers])
    cascade = propagation.trace(perceived, propagation.first_step(warned), heard)
    told, direct = cascade.told.sum(), cascade.direct.sum()
    edges = (cascade.parent >= 0).sum()
    assert told / (inputs["n_agents"] - direct) == close(expected["social_reach"])
    assert (told + direct) / inputs["n_agents"] == close(expected["informed_fraction"])
    assert edges / (told + direct) == close(expected["R_mean_secondary"])
    assert propagation.relay_probability(cascade, warned) == close(expected["relay_probability"])
    assert (propagation.depth(cascade), propagation.trees(cascade)) == (expected["depth"], expected["trees"])


def test_the_kaplan_meier_curve_and_its_area():
    inputs, expected = example("km_time_to_first_warned")
    times, observed = np.array(inputs["times"]), np.array(inputs["observed"], dtype=bool)
    events, remaining = propagation.survival(times, observed)
    assert dict(zip(events.tolist(), remaining.tolist(), strict=True)) == close(
        {step: expected[f"S{step}"] for step in (1, 2, 3, 4)}
    )
    assert propagation.restricted_mean(times, observed, inputs["T"]) == close(expected["rmst5"])


def test_what_an_oracle_could_reach():
    inputs, expected = example("oracle_reachability")
    links = np.array([(t, a, b) for t, i, j in inputs["contacts"] for a, b in ((i, j), (j, i))])
    knows = np.full(5, propagation.NEVER)
    knows[inputs["source"]] = inputs["t0"]
    reached = propagation.spread(knows, links) < knows
    assert reached.sum() / 4 == close(expected)


def test_attendance():
    inputs, expected = example("attendance_volatility")
    assert place_choice.volatility(np.array(inputs["attendance"]), inputs["N"]) == close(expected)
    inputs, expected = example("overcrowding_rate")
    assert place_choice.overcrowding(np.array(inputs["attendance"]), inputs["comfort"]) == close(expected)
    inputs, expected = example("capacity_utilisation")
    assert place_choice.utilisation(np.array(inputs["attendance"]), inputs["capacity"]) == close(expected)
    inputs, expected = example("choice_entropy_normalised")
    assert normalised_entropy(inputs["counts"]) == close(expected)


def test_idle_rates():
    inputs, expected = example("idle_rate")
    moved = np.array(inputs["moved"], dtype=bool)
    stay = choices(inputs["actions"]) == STAY
    parts = idle_rate.idle_parts(stay, moved, np.ones(len(moved), dtype=bool))
    assert {name: parts[name] for name in ("chosen", "blocked", "immobile")} == close(
        {name: expected[name] for name in ("chosen", "blocked", "immobile")}
    )
    assert longest_run(~moved) == expected["longest_immobile_run"]


def test_directions():
    inputs, expected = example("direction_entropy")
    counts = np.array([inputs["counts"][name] for name in COMPASS])
    assert (entropy(counts), normalised_entropy(counts)) == close((expected["bits"], expected["normalised"]))
    assert movement.resultant_length(counts) == close(example("mean_resultant_length")[1]["R"])


def test_stability_of_actions():
    inputs, expected = example("action_persistence")
    actions = choices(inputs["actions"])
    assert (actions[:-1] == actions[1:]).mean() == close(expected["repeat"])
    assert stability.kappa(actions[:-1], actions[1:]) == close(expected["kappa"])
    assert run_lengths(actions).mean() == close(expected["mean_run_length"])
    inputs, expected = example("conditional_action_entropy")
    actions = choices(inputs["actions"])
    assert stability.conditional_entropy(actions[:-1], actions[1:]) == close(expected)


def test_how_much_is_said_by_whom():
    inputs, expected = example("message_rate_and_gini")
    counts = np.array(inputs["messages_per_agent"])
    assert counts.sum() / (len(counts) * inputs["T"]) == close(expected["rate"])
    assert communication.gini(counts) == close(expected["gini"])


def test_the_rhythm_of_messages():
    inputs, expected = example("burstiness")
    times = np.array(inputs["event_times"])
    assert communication.burstiness(times) == close(expected["B"])
    assert communication.burstiness(times, finite=True) == close(expected["B_finite"])


def test_links_that_go_both_ways():
    inputs, expected = example("message_reciprocity")
    assert communication.reciprocity({tuple(edge) for edge in inputs["edges"]}) == close(expected)


def test_exploration_of_a_path():
    inputs, expected = example("coverage_entropy_rog")
    found = exploration.path_measures(np.array(inputs["path"]), inputs["reachable_cells"])
    assert found == close(
        {
            "coverage": expected["coverage"],
            "unique_ratio": 3 / 5,
            "visit_entropy": expected["entropy_norm"],
            "gyration": expected["rog"],
            "revisit_rate": expected["revisit"],
        }
    )


def test_the_interval_of_a_mean():
    inputs, expected = example("paired_t_ci")
    found = estimate(np.array(inputs["diffs"]))
    assert [found.low, found.high] == close(expected)
