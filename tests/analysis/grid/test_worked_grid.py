"""The signatures of 2D worlds against worked examples that were checked with independent libraries."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.arrays import STAY
from analysis.formulas import entropy, jensen_shannon, longest_run, normalised_entropy
from analysis.grid.grid_run import CHOICES, Fire
from analysis.grid.placements import besag, closeness, random_placements
from analysis.grid.signatures import (
    clustering,
    communication,
    exploration,
    hazard,
    idle_rate,
    movement,
    place_choice,
    stability,
)
from analysis.grid.walker import direction_shares, expected_cells
from analysis.logit import conditional_logit
from grid_runs import grid_run

EXAMPLES = json.loads(Path(__file__).with_name("worked_examples.json").read_text(encoding="utf-8"))
COMPASS = {"N": "up", "S": "down", "W": "left", "E": "right"}
"""In the order of the directions."""


def example(name: str) -> tuple[Any, Any]:
    return EXAMPLES[name]["inputs"], EXAMPLES[name]["expected"]


def close(expected: object) -> object:
    return pytest.approx(expected, abs=1e-9, rel=1e-9)


def points(inputs: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.array(inputs["points"]).T
    return x[None], y[None]


def choices(actions: Sequence[str]) -> np.ndarray:
    """Return what one agent asked for, (T, 1): `stay`, or a direction of the compass."""
    return np.array([[CHOICES.index(COMPASS.get(action, action))] for action in actions])


@pytest.mark.parametrize(("name", "corrected"), [("nni_clark_evans_naive", False), ("nni_donnelly", True)])
def test_nearest_neighbour_indices(name: str, corrected: bool):
    inputs, expected = example(name)
    left, right, bottom, top = inputs["window"]
    observed = closeness(*points(inputs), side=right - left, radius=1.0).nearest
    random = clustering.expected_distance(len(inputs["points"]), right - left, top - bottom, corrected=corrected)
    assert observed / random == close(expected)


def test_ripleys_k_and_besags_l():
    inputs, expected = example("ripley_K_uncorrected")
    found = [closeness(*points(inputs), side=10, radius=radius).pairs[0] for radius in inputs["r"]]
    assert np.array(found) * inputs["area"] == close(expected)
    inputs, expected = example("ripley_K_translation")
    assert closeness(*points(inputs), side=10, radius=inputs["r"]).ripley == close(expected)
    inputs, expected = example("besag_L_minus_r")
    assert besag(np.array([inputs["K"]]), inputs["r"]) == close(expected)


def test_proximity_groups():
    inputs, expected = example("proximity_components")
    cells = inputs["points"]
    near = [
        (1, i, j)
        for i, a in enumerate(cells)
        for j, b in enumerate(cells)
        if i != j and math.dist(a, b) <= inputs["radius"]
    ]
    shape = clustering.group_shape(np.array(near), np.ones((1, len(cells)), dtype=np.bool_))
    assert shape[0].tolist() == close(
        [expected["largest_fraction"], expected["n_groups_ge2"], expected["isolated_fraction"]]
    )


@pytest.mark.parametrize(
    ("name", "measure", "limit"),
    [
        ("attendance_volatility", "volatility", None),
        ("overcrowding_rate", "overcrowding", "comfort"),
        ("capacity_utilisation", "utilisation", "capacity"),
    ],
)
def test_attendance(name: str, measure: str, limit: str | None):
    inputs, expected = example(name)
    present = np.array(inputs["attendance"])
    capacity = inputs[limit] if limit else 12
    found = place_choice.attendance_measures(present, capacity, 20, np.ones(len(present), dtype=np.int64))
    assert found[measure] == close(expected)


def test_entropy_of_choices_and_divergence_between_models():
    inputs, expected = example("choice_entropy_normalised")
    assert normalised_entropy(inputs["counts"]) == close(expected)
    inputs, expected = example("jsd_choice_between_models")
    assert jensen_shannon(inputs["p"], inputs["q"]) == close(expected)


def test_idle_rates():
    inputs, expected = example("idle_rate")
    moved = np.array(inputs["moved"], dtype=np.bool_)
    stay = choices(inputs["actions"])[:, 0] == STAY
    parts = idle_rate.idle_parts(stay, moved, np.ones(len(moved), dtype=np.bool_))
    assert {name: parts[name] for name in ("chosen", "blocked", "immobile")} == close(
        {name: expected[name] for name in ("chosen", "blocked", "immobile")}
    )
    assert longest_run(~moved) == expected["longest_immobile_run"]


def test_directions_and_those_of_a_walker_between_walls():
    inputs, expected = example("direction_entropy")
    counts = [inputs["counts"][name] for name in COMPASS]
    actions = [way for way, count in zip(COMPASS, counts, strict=True) for _ in range(count)]
    offsets = {"N": (0, 1), "S": (0, -1), "W": (-1, 0), "E": (1, 0)}
    path = np.cumsum([(0, 0), *(offsets[way] for way in actions)], axis=0)
    found = movement.measure(grid_run([path.tolist()]))
    for prefix in ("direction", "asked"):
        assert found[f"{prefix}_bits"] == close(expected["bits"])
        assert found[f"{prefix}_entropy"] == close(expected["normalised"])
        assert found[f"{prefix}_kl"] == close(expected["kl_uniform_bits"])
    expected = example("mean_resultant_length")[1]
    assert (found["resultant_length"], found["mean_direction"]) == close((expected["R"], expected["mean_deg"]))
    inputs, expected = example("direction_null_with_walls")
    legal = np.array([[name in names for name in COMPASS] for names in inputs["legal"]])
    assert direction_shares(legal) == close([expected[name] for name in COMPASS])


def test_stability_of_actions():
    inputs, expected = example("action_persistence")
    actions = choices(inputs["actions"])
    found = stability.measure(grid_run([[(0, 0)] * (len(actions) + 1)], choice=actions))
    assert found["persistence"] == close(expected["repeat"])
    assert found["kappa"] == close(expected["kappa"])
    assert found["run_length"] == close(expected["mean_run_length"])
    assert found["conditional_entropy"] == close(example("conditional_action_entropy")[1])


def test_messages_by_how_much_is_said_their_rhythm_and_their_links():
    inputs, expected = example("message_rate_and_gini")
    counts, steps = inputs["messages_per_agent"], inputs["T"]
    said = np.array([["hello" if step < count else None for count in counts] for step in range(steps)], dtype=object)
    found = communication.measure(grid_run([[(0, 0)] * (steps + 1)] * len(counts), said=said))
    assert (found["rate"], found["silent_share"], found["gini"]) == close(
        (expected["rate"], expected["silent"], expected["gini"])
    )
    inputs, expected = example("burstiness")
    times = np.array(inputs["event_times"])
    assert communication.burstiness(times) == close(expected["B"])
    assert communication.burstiness(times, finite=True) == close(expected["B_finite"])
    inputs, expected = example("message_reciprocity")
    links = np.zeros((4, 4), dtype=np.bool_)
    links[tuple(np.array(inputs["edges"]).T)] = True
    assert communication.reciprocity(links) == close(expected)


def test_exploration_of_a_path_and_of_a_walk_on_the_infinite_lattice():
    inputs, expected = example("coverage_entropy_rog")
    found = exploration.measure(grid_run([inputs["path"]], half_size=1))
    assert inputs["reachable_cells"] == found["n_cells"]
    assert (found["coverage"], found["visit_entropy"], found["gyration"], found["revisit_rate"]) == close(
        (expected["coverage"], expected["entropy_norm"], expected["rog"], expected["revisit"])
    )
    assert entropy([1, 3, 1]) == close(expected["entropy_bits"])
    inputs, expected = example("random_walk_distinct_sites_Z2")
    moves = np.array(inputs["steps"])
    middle = np.zeros(len(moves), dtype=np.int64)
    assert expected_cells(middle, middle, moves, half_size=30) == close([expected[str(n)] for n in inputs["steps"]])


def test_what_a_fire_in_sight_changes():
    inputs, expected = example("hazard_contrast")
    found = hazard.contrast(*inputs.values())
    assert (found.difference, math.exp(found.log_odds_ratio)) == close((expected["rd"], expected["haldane_or"]))
    away, other, control_away, control_other = inputs.values()
    corrected = (away + 0.5) / (away + other + 0.5) * (control_away + control_other + 0.5) / (control_away + 0.5)
    assert math.exp(found.log_risk_ratio) == close(corrected)
    inputs, expected = example("step_selection_conditional_logit")
    sets, away = inputs["choice_sets"], inputs["chosen_away"]
    options = np.tile(np.array([[1.0], [0.0]]), (sets, 1, 1))
    chosen = np.where(np.arange(sets) < away, 0, 1)
    assert conditional_logit(options, np.ones((sets, 2), dtype=np.bool_), chosen) == close(expected)
    inputs, expected = example("mean_distance_change_exposed")
    path = [(distance, 0) for distance in inputs["d_fire"]]
    seen = np.array(inputs["exposed"], dtype=np.bool_)[:, None, None]
    found = hazard.measure(grid_run([path], fires=[Fire("fire", 1, (0, 0), 9.0)], fires_seen=seen))
    assert found["distance_change"] == close(expected)
    assert found["n_exposed"] == sum(inputs["exposed"])


@pytest.mark.parametrize(("agents", "side", "naive", "donnelly"), [(20, 50, 1.11, 1.00), (5, 50, 1.25, 1.00)])
def test_what_random_placements_come_to(agents: int, side: int, naive: float, donnelly: float):
    """Against 4,000 placements that were drawn elsewhere; tolerance: four standard errors of 999 draws."""
    null = random_placements(agents, side, 5.0)
    plain = clustering.expected_distance(agents, side, side, corrected=False)
    error = 4 * null.deviation / math.sqrt(999) / plain + 0.005  # the figures have two digits
    assert null.nearest / plain == pytest.approx(naive, abs=error)
    assert null.nearest / clustering.expected_distance(agents, side, side) == pytest.approx(donnelly, abs=error)
