"""Warnings, ways, stability and recognition against worked examples that were checked with independent libraries."""

from __future__ import annotations

import json
import math
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from scipy import stats

from analysis.agreement import fleiss_kappa, pairwise_agreement
from analysis.camera.signatures.recognition import agreement, hallucination
from analysis.grid.cascade import NEVER, Cascade, find_relays, first_step, spread, trace
from analysis.grid.distances import steps_to
from analysis.kaplan_meier import restricted_mean, survival

EXAMPLES = json.loads(Path(__file__).with_name("worked_examples_3d.json").read_text(encoding="utf-8"))


def example(name: str):
    return EXAMPLES[name]["inputs"], EXAMPLES[name]["expected"]


def close(expected: object) -> object:
    return pytest.approx(expected, abs=1e-9, rel=1e-9)


def forest(edges: list[list[int]], agents: int) -> Cascade:
    """Return a cascade of these edges (from, to), told in the order of their distance from agent 0."""
    parent, told_at = np.full(agents, -1), np.full(agents, NEVER)
    for source, target in edges:
        parent[target] = source
    lengths = nx.single_source_shortest_path_length(nx.DiGraph(edges), 0)
    for agent, length in lengths.items():
        told_at[agent] = length if length else NEVER
    told = told_at < NEVER
    return Cascade(direct=~told, told=told, told_at=told_at, parent=parent)


@pytest.mark.parametrize("name", ["structural_virality_star5", "structural_virality_chain5"])
def test_structural_virality(name: str):
    inputs, expected = example(name)
    assert forest(inputs["edges"], 5).virality == close(expected)


def test_virality_is_averaged_over_trees_and_undefined_without_any():
    alone = np.full(7, -1)
    never = np.full(7, NEVER)
    nobody = np.zeros(7, dtype=bool)
    assert math.isnan(Cascade(nobody, nobody, never, alone).virality)
    star, pair = [[0, 1], [0, 2], [0, 3]], [[4, 5]]
    parent = np.array([-1, 0, 0, 0, -1, 4, -1])
    told_at = np.array([NEVER, 1, 1, 1, NEVER, 2, NEVER])
    expected = [nx.average_shortest_path_length(nx.Graph(edges)) for edges in (star, pair)]
    assert Cascade(nobody, nobody, told_at, parent).virality == close(np.mean(expected))


def test_a_warning_cascade_and_who_had_no_chance_to_pass_one_on():
    inputs, expected = example("warning_cascade")
    agents, steps = inputs["n_agents"], inputs["T"]
    perceived = np.full(agents, NEVER)
    for agent, step in inputs["perceived"].items():
        perceived[int(agent)] = step
    warned = np.zeros((steps, agents), dtype=bool)
    for step, sender, _ in inputs["warnings"]:
        warned[step - 1, sender] = True
    heard = np.array([(step, sender, one) for step, sender, receivers in inputs["warnings"] for one in receivers])
    cascade = trace(perceived, first_step(warned), heard)
    told, direct = cascade.told.sum(), cascade.direct.sum()
    able = np.ones((steps, agents), dtype=bool)
    relays = find_relays(warned[None], cascade.told_at[None], perceived, able=able, within=5)
    assert told / (agents - direct) == close(expected["social_reach"])
    assert (told + direct) / agents == close(expected["informed_fraction"])
    assert cascade.edges / (told + direct) == close(expected["R_mean_secondary"])
    assert relays.shares.tolist() == close([expected["relay_probability"]])
    assert (cascade.depth, cascade.trees) == (expected["depth"], expected["trees"])
    warned = np.zeros((1, 4, 3), dtype=bool)
    warned[0, 3, 1] = True
    told_at, never = np.array([[4, 2, NEVER]]), np.full(3, NEVER)
    relays = find_relays(warned, told_at, never, able=np.ones((4, 3), dtype=bool), within=5)
    assert (relays.could.tolist(), relays.did.tolist()) == ([1], [1])
    none = find_relays(warned, told_at, never, able=np.zeros((4, 3), dtype=bool), within=5)
    assert math.isnan(none.shares[0])


def test_the_kaplan_meier_curve_and_its_area():
    inputs, expected = example("km_time_to_first_warned")
    times, observed = np.array(inputs["times"]), np.array(inputs["observed"], dtype=bool)
    events, remaining = survival(times, observed)
    assert dict(zip(events.tolist(), remaining.tolist(), strict=True)) == close(
        {step: expected[f"S{step}"] for step in (1, 2, 3, 4)}
    )
    assert events[remaining <= 0.5][0] == expected["median"]
    assert restricted_mean(times, observed, inputs["T"]) == close(expected["rmst5"])
    inputs, expected = example("km_median_exact_half_tie")
    times, observed = np.array(inputs["times"]), np.array(inputs["observed"], dtype=bool)
    events, remaining = survival(times, observed)
    assert remaining[events == 2][0] == close(0.5)
    assert events[remaining < 0.5 - 1e-9][0] == expected  # so no median is reported
    rng = np.random.default_rng(0)
    times, observed = rng.integers(1, 9, 40), rng.random(40) < 0.6
    events, remaining = survival(times, observed)
    found = stats.ecdf(stats.CensoredData(uncensored=times[observed], right=times[~observed])).sf
    assert remaining.tolist() == close(found.evaluate(events).tolist())
    times, observed = np.array([1, 3, 6]), np.array([True, True, True])
    assert restricted_mean(times, observed, 2) == close(1 + 2 / 3)
    assert math.isnan(restricted_mean(times[:0], observed[:0], 5))


def test_what_an_oracle_could_reach():
    inputs, expected = example("oracle_reachability")
    links = np.array([(t, a, b) for t, i, j in inputs["contacts"] for a, b in ((i, j), (j, i))])
    knows = np.full(5, NEVER)
    knows[inputs["source"]] = inputs["t0"]
    assert (spread(knows, links) < knows).sum() / 4 == close(expected)


def test_steps_on_a_grid_go_around_walls():
    inputs, expected = example("grid_geodesic_with_wall")
    free, goal = np.ones(inputs["grid"], dtype=bool), np.zeros(inputs["grid"], dtype=bool)
    for cell in inputs["wall"]:
        free[tuple(cell)] = False
    goal[tuple(inputs["goal"])] = True
    found = steps_to(goal, free)
    assert found[tuple(inputs["start"])] == expected
    assert (found[2, 0], found[4, 0]) == (-1, 0)
    free[2, 4] = False
    assert steps_to(goal, free)[0, 0] == -1


def test_consistency_of_repeated_choices():
    inputs, expected = example("test_retest_fleiss")
    counts = np.array(inputs["table"])
    assert pairwise_agreement(counts) == close(expected["agreement"])
    assert fleiss_kappa(counts) == close(expected["kappa"])
    assert math.isnan(fleiss_kappa(np.array([[3, 0], [4, 0]])))
    assert pairwise_agreement(np.array([[3, 0], [4, 0]])) == 1


def test_a_yes_or_no_probe_and_frames_with_hallucinations():
    inputs, expected = example("pope_probe")
    cells = [(True, True), (True, False), (False, True), (False, False)]
    answers = [pair for pair, name in zip(cells, ("tp", "fp", "fn", "tn"), strict=True) for _ in range(inputs[name])]
    found = agreement(*np.array(answers).T)
    wanted = {"accuracy": "acc", "f1": "f1", "claim_rate": "yes_ratio", "mcc": "mcc"}
    assert {name: found[name] for name in wanted} == close({name: expected[key] for name, key in wanted.items()})
    inputs, expected = example("chair_s")
    named = [{f"thing {number}" for number in range(count)} for count in inputs["hallucinated_per_frame"]]
    found = hallucination(named, [set()] * len(named))
    assert found["chair_s"] == close(expected)
    assert (found["chair_i"], math.isnan(found["object_recall"])) == (1, True)
    found = hallucination([set(), set()], [{"door"}, set()])
    assert math.isnan(found["chair_i"])
    assert (found["chair_s"], found["mentions"], found["object_recall"]) == (0, 0, 0)
