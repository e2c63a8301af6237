"""Every measure once more, from the JSON lines, with plain loops that share no code with the analysis."""

from __future__ import annotations

import json
import math
import statistics
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import networkx as nx
import pytest

from analysis import signatures
from analysis.run import GridRun

WARNINGS = {"fire1 near me", "火事だ、逃げて", "there is smoke"}
OPPOSITE = {"up": "down", "down": "up", "left": "right", "right": "left"}
Row = dict[str, Any]


class Plain:
    """One run as dictionaries, by step and agent."""

    def __init__(self, folder: Any) -> None:
        self.world = folder.config()["world"]
        rows = [json.loads(line) for line in (folder.path / "steps.jsonl").read_text("utf-8").splitlines()]
        self.rows = {(row["step"], row["agent"]): row for row in rows}
        self.heard = [json.loads(line) for line in (folder.path / "messages.jsonl").read_text("utf-8").splitlines()]
        self.steps, self.agents = range(1, max(row["step"] for row in rows) + 1), range(self.world["agents"])

    def at(self, agent: int) -> list[Row]:
        return [self.rows[step, agent] for step in self.steps]

    def path(self, agent: int) -> list[tuple[int, int]]:
        rows = self.at(agent)
        return [(rows[0]["x"], rows[0]["y"]), *((row["x_next"], row["y_next"]) for row in rows)]

    def place(self, cell: tuple[int, int]) -> str | None:
        for place in self.world["places"]:
            offsets = (cell[0] - place["center"][0], cell[1] - place["center"][1])
            if all(abs(offset) <= extent for offset, extent in zip(offsets, place["extent"], strict=True)):
                return str(place["name"])
        return None

    def stays(self, agent: int) -> list[str | None]:
        return [self.place(cell) for cell in self.path(agent)]


def over(part: float, whole: float) -> float:
    return part / whole if whole else math.nan


def average(values: Iterable[float]) -> float:
    kept = list(values)
    return over(sum(kept), len(kept))


def bits(counts: Iterable[int]) -> float:
    kept = [count for count in counts if count]
    total = sum(kept)
    return -sum(count / total * math.log2(count / total) for count in kept) if kept else math.nan


def clustering(run: Plain) -> Iterator[tuple[str, float]]:
    side, agents = 2 * run.world["half_size"] + 1, len(run.agents)
    naive = 0.5 * math.sqrt(side * side / agents)
    nearest = []
    for step in run.steps:
        cells = [run.path(agent)[step] for agent in run.agents]
        nearest.append(
            average(min(math.dist(a, b) for j, b in enumerate(cells) if j != i) for i, a in enumerate(cells))
        )
    yield "nni_naive", average(value / naive for value in nearest)
    donnelly = naive + (0.0514 + 0.0412 / math.sqrt(agents)) * 4 * side / agents
    yield "nni_donnelly", average(value / donnelly for value in nearest)
    largest, groups, isolated = [], [], []
    for step in run.steps[1:]:
        graph = nx.Graph()
        graph.add_nodes_from(run.agents)
        graph.add_edges_from((i, j) for i in run.agents for j in run.rows[step, i]["neighbours"])
        sizes = [len(component) for component in nx.connected_components(graph)]
        largest.append(max(sizes) / agents)
        groups.append(sum(size > 1 for size in sizes))
        isolated.append(sum(size == 1 for size in sizes) / agents)
    yield from {
        "largest_group": average(largest),
        "groups": average(groups),
        "isolated": average(isolated),
    }.items()
    yield from {"n_states": len(run.steps), "n_group_states": len(run.steps) - 1}.items()


def relayed(run: Plain, perceived: dict[int, int], links: Iterable[tuple[int, int, int]]) -> dict[int, int]:
    links, reached = list(links), {}
    for step in run.steps:
        known = {i for i in run.agents if perceived.get(i, math.inf) <= step or i in reached}
        for when, source, target in links:
            if when == step and source in known:
                reached.setdefault(target, step)
    return {agent: step for agent, step in reached.items() if step < perceived.get(agent, math.inf)}


def reach(run: Plain, reached: dict[int, int], perceived: dict[int, int]) -> float:
    return over(len(reached), len(run.agents) - len(set(perceived) - set(reached)))


def warning(run: Plain) -> Iterator[tuple[str, float]]:
    last = len(run.steps)
    perceived = {i: step for i in run.agents for step in reversed(run.steps) if run.rows[step, i]["fires"]}
    sent = [(step, i) for step in run.steps for i in run.agents if run.rows[step, i]["message"] in WARNINGS]
    heard = [(m["step"], m["sender"], m["recipient"]) for m in run.heard if m["text"] in WARNINGS]
    first: dict[int, tuple[int, int]] = {}
    for step, source, target in sorted(heard):
        first.setdefault(target, (step, source))
    told = {i: step for i, (step, _) in first.items() if step < perceived.get(i, math.inf)}
    direct = set(perceived) - set(told)
    spoken = {i: min(step for step, who in sent if who == i) for _, i in sent}
    tree = nx.DiGraph([(first[i][1], i) for i in told if spoken.get(i, math.inf) > told[i]])
    links = [(step, i, j) for step in run.steps for i in run.agents for j in run.rows[step, i]["neighbours"]]
    traced, reachable = relayed(run, perceived, heard), relayed(run, perceived, links)
    waits = [(told[i], True) if i in told else (perceived.get(i, last + 1) - 1, False) for i in run.agents]
    needing_fire = {
        "informed_fraction": (len(told) + len(direct)) / len(run.agents),
        "social_reach": reach(run, told, perceived),
        "traced_reach": reach(run, traced, perceived),
        "oracle_reach": reach(run, reachable, perceived),
        "normalised_reach": over(len(traced), len(reachable)),
        "relay_probability": average(any(told[i] < s <= told[i] + 5 for s, who in sent if who == i) for i in told),
        "reproduction": over(tree.number_of_edges(), len(told) + len(direct)),
        "depth": nx.dag_longest_path_length(tree) if tree else 0,
        "trees": nx.number_weakly_connected_components(tree) if tree else 0,
        "rmst": kaplan_meier_area(waits, last) if len(direct) < len(run.agents) else math.nan,
    }
    yield from ((name, value if perceived else math.nan) for name, value in needing_fire.items())
    grounds = [
        (step, i) for step, i in sent if perceived.get(i, math.inf) <= step or (i in first and first[i][0] < step)
    ]
    said = [row for row in run.rows.values() if row["message"] is not None]
    yield "false_alarm_rate", over(len(sent) - len(grounds), len(said))
    yield "warning_share", over(len(sent), len(said))
    yield from {"n_direct": len(direct), "n_told": len(told), "n_reachable": len(reachable)}.items()
    yield from {"n_warnings": len(sent), "n_messages": len(said)}.items()


def kaplan_meier_area(times: list[tuple[int, bool]], horizon: int) -> float:
    area, alive = 0.0, 1.0
    for moment in range(horizon):
        at_risk = [time for time, _ in times if time >= moment]
        events = sum(seen and time == moment for time, seen in times)
        alive *= 1 - events / len(at_risk) if events else 1.0
        area += alive
    return area


def place_choice(run: Plain) -> Iterator[tuple[str, float]]:
    stays = {agent: run.stays(agent) for agent in run.agents}
    names = [place["name"] for place in run.world["places"]]
    states = [[stays[agent][step] for agent in run.agents] for step in run.steps]
    flat = Counter(stay for state in states for stay in state)
    entered = [
        next((now for before, now in zip(own, own[1:], strict=False) if now and now != before), None)
        for own in stays.values()
    ]
    crowding: dict[str, list[float]] = {"overcrowding": [], "utilisation": [], "volatility": []}
    for place in run.world["places"]:
        name, capacity = place["name"], place["capacity"]
        present = [state.count(name) for state in states]
        yield f"share_{name}", flat[name] / len(run.rows)
        yield f"first_choice_{name}", over(entered.count(name), len(run.agents) - entered.count(None))
        crowding["overcrowding"].append(average(count > capacity for count in present))
        crowding["utilisation"].append(average(min(count, capacity) / capacity for count in present))
        crowding["volatility"].append(statistics.pvariance(present) / len(run.agents))
    for kind, values in crowding.items():
        yield kind, average(values)
        yield from ((f"{kind}_{name}", value) for name, value in zip(names, values, strict=True))
    yield "share_outside", flat[None] / len(run.rows)
    yield "entropy", bits(flat.values()) / math.log2(len(names) + 1)
    yield "entropy_places", bits(flat[name] for name in names) / math.log2(len(names))
    yield from {"n_states": len(run.steps), "n_agent_states": len(run.rows)}.items()
    yield from {
        "n_in_place": sum(flat.values()) - flat[None],
        "n_entering": len(entered) - entered.count(None),
    }.items()


def is_readable(row: Row) -> bool:
    return row["outcome"] in ("chosen", "repaired")


def idle_rate(run: Plain) -> Iterator[tuple[str, float]]:
    rows = run.rows.values()
    chosen = sum(row["action"] == "stay" and is_readable(row) for row in rows)
    yield "chosen", chosen / len(rows)
    yield "chosen_readable", over(chosen, sum(map(is_readable, rows)))
    yield "blocked", sum(row["action"] == "move" and not row["moved"] for row in rows) / len(rows)
    yield "invalid", sum(not is_readable(row) for row in rows) / len(rows)
    yield "immobile", sum(not row["moved"] for row in rows) / len(rows)
    longest = []
    for agent in run.agents:
        current, best = 0, 0
        for row in run.at(agent):
            current = 0 if row["moved"] else current + 1
            best = max(best, current)
        longest.append(best)
    yield "longest_run", average(longest)
    yield from {"n_decisions": len(rows), "n_readable": sum(map(is_readable, rows))}.items()


def communication(run: Plain) -> Iterator[tuple[str, float]]:
    rows = list(run.rows.values())
    said = [row for row in rows if row["message"] is not None]
    near = [row for row in rows if row["neighbours"]]
    counts = [sum(row["agent"] == agent for row in said) for agent in run.agents]
    gaps = []
    for agent in run.agents:
        times = [row["step"] for row in run.at(agent) if row["message"] is not None]
        if len(times) > 2:
            gaps.append([after - before for before, after in zip(times, times[1:], strict=False)])
    spreads = [(statistics.pstdev(own) / statistics.mean(own), len(own)) for own in gaps]
    graph = nx.DiGraph([(message["sender"], message["recipient"]) for message in run.heard])
    yield "rate", len(said) / len(rows)
    yield "conditional_rate", over(sum(row["message"] is not None for row in near), len(near))
    yield "silent_share", counts.count(0) / len(counts)
    pairs = [abs(a - b) for a in counts for b in counts]
    yield "gini", over(average(pairs), 2 * average(counts))
    yield "burstiness", average((r - 1) / (r + 1) for r, _ in spreads)
    finite = [
        (math.sqrt(n + 1) * r - math.sqrt(n - 1)) / ((math.sqrt(n + 1) - 2) * r + math.sqrt(n - 1)) for r, n in spreads
    ]
    yield "burstiness_finite", average(finite)
    yield "reciprocity", nx.reciprocity(graph) if graph else math.nan
    yield "audience", over(len(run.heard), len(said))
    yield "length", average(len(row["message"]) for row in said)
    yield "distinct_share", over(len({row["message"] for row in said}), len(said))
    yield from {"n_messages": len(said), "n_deliveries": len(run.heard), "n_decisions": len(rows)}.items()
    yield from {"n_with_neighbour": len(near), "n_links": len(graph.edges), "n_rhythmic": len(gaps)}.items()


def outcome(run: Plain) -> Iterator[tuple[str, float]]:
    rows = list(run.rows.values())
    for prefix, key in (("", "outcome"), ("message_", "message_outcome")):
        for name in ("chosen", "repaired", "unreadable", "empty", "truncated", "failed"):
            yield prefix + name, sum(row[key] == name for row in rows) / len(rows)
        yield f"{prefix}readable", sum(row[key] in ("chosen", "repaired") for row in rows) / len(rows)
        yield f"n_{prefix}decisions", len(rows)


def path_efficiency(run: Plain) -> Iterator[tuple[str, float]]:
    half = run.world["half_size"]
    grid = nx.grid_2d_graph(range(-half, half + 1), range(-half, half + 1))
    waiting, moving, arrived = [], [], 0
    for agent in run.agents:
        stays, path = run.stays(agent), run.path(agent)
        arrived += stays[-1] is not None
        if stays[-1] is not None and stays[0] != stays[-1]:
            taken = stays.index(stays[-1])
            lengths = nx.single_source_shortest_path_length(grid, path[0])
            shortest = min(length for cell, length in lengths.items() if run.place(cell) == stays[-1])
            waiting.append(shortest / taken)
            moving.append(shortest / sum(a != b for a, b in zip(path[:taken], path[1 : taken + 1], strict=True)))
    yield "trip_efficiency", average(waiting)
    yield "trip_efficiency_moving", average(moving)
    yield "arrived", arrived / len(run.agents)
    yield from {"n_trips": len(waiting), "n_agents": len(run.agents)}.items()


def movement(run: Plain) -> Iterator[tuple[str, float]]:
    made = Counter(row["direction"] for row in run.rows.values() if row["moved"])
    asked = Counter(row["direction"] for row in run.rows.values() if row["direction"])
    total = sum(made.values())
    yield "direction_bits", bits(made.values())
    yield "direction_entropy", bits(made.values()) / 2
    yield "asked_entropy", bits(asked.values()) / 2
    yield (
        "resultant_length",
        over(abs(complex(made["right"] - made["left"], made["up"] - made["down"])), total),
    )
    yield from ((f"share_{name}", over(made[name], total)) for name in OPPOSITE)
    yield from {"n_moves": total, "n_asked": sum(asked.values())}.items()


def exploration(run: Plain) -> Iterator[tuple[str, float]]:
    cells, states = (2 * run.world["half_size"] + 1) ** 2, len(run.steps) + 1
    paths = [run.path(agent) for agent in run.agents]
    yield "coverage", average(len(set(path)) / cells for path in paths)
    yield "group_coverage", len({cell for path in paths for cell in path}) / cells
    yield "unique_ratio", average(len(set(path)) / states for path in paths)
    yield "revisit_rate", average((states - len(set(path))) / states for path in paths)
    yield "visit_entropy", average(bits(Counter(path).values()) / math.log2(cells) for path in paths)
    yield (
        "gyration",
        average(math.sqrt(sum(statistics.pvariance(axis) for axis in zip(*p, strict=True))) for p in paths),
    )
    yield from {"n_agents": len(run.agents), "n_states": states, "n_cells": cells}.items()


def stability(run: Plain) -> Iterator[tuple[str, float]]:
    pairs, lengths = [], []
    for agent in run.agents:
        rows = run.at(agent)
        pairs += list(zip(rows, rows[1:], strict=False))
        current = 1
        for before, after in zip(rows, rows[1:], strict=False):
            if before["direction"] != after["direction"]:
                lengths.append(current)
                current = 0
            current += 1
        lengths.append(current)
    readable = [pair for pair in pairs if all(map(is_readable, pair))]
    for suffix, kept in (("", pairs), ("_readable", readable)):
        agreed = average(a["direction"] == b["direction"] for a, b in kept)
        before, after = (Counter(pair[side]["direction"] for pair in kept) for side in (0, 1))
        chance = over(sum(before[name] * after[name] for name in before), len(kept) ** 2)
        yield f"persistence{suffix}", agreed
        yield f"kappa{suffix}", over(agreed - chance, 1 - chance)
    joint = Counter((a["direction"], b["direction"]) for a, b in pairs)
    yield (
        "conditional_entropy",
        bits(joint.values()) - bits(Counter(a["direction"] for a, _ in pairs).values()),
    )
    moves = [(a["direction"], b["direction"]) for a, b in pairs if a["direction"] and b["direction"]]
    yield "reversal_rate", average(OPPOSITE[a] == b for a, b in moves)
    yield "run_length", average(lengths)
    yield from {"n_pairs": len(pairs), "n_readable_pairs": len(readable), "n_move_pairs": len(moves)}.items()


RECOMPUTED: dict[str, Callable[[Plain], Iterator[tuple[str, float]]]] = {
    check.__name__: check
    for check in (
        clustering, warning, place_choice, idle_rate, communication,
        outcome, path_efficiency, movement, exploration, stability,
    )
}  # fmt: skip


GRID = [signature for signature in signatures.discover() if GridRun in signature.functions]


def test_every_signature_of_2d_runs_is_recomputed():
    assert set(RECOMPUTED) == {signature.name for signature in GRID}


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("signature", GRID, ids=lambda one: one.name)
def test_a_signature_agrees_with_plain_loops(signature, seed, recorded, make_habits):
    habits = make_habits(speak=(0.4, 0.08, 0.9, 0.15)[seed])
    written = recorded(seed=seed, habits=habits, steps=(25, 40, 12, 60)[seed])
    expected = dict(RECOMPUTED[signature.name](Plain(written.folder)))
    found = signature.measure(written.run)
    assert set(found) == set(expected)
    assert found == pytest.approx(expected, abs=1e-9, rel=1e-9, nan_ok=True)


@pytest.mark.parametrize("signature", GRID, ids=lambda one: one.name)
def test_every_measure_is_described_and_lies_in_its_range(signature, recorded):
    for name, value in signature.measure(recorded(seed=5).run).items():
        described = signature.describe(name)
        assert isinstance(value, float)
        assert described.label != name, f"{name} is not described"
        assert math.isnan(value) or described.low <= value <= described.high


@pytest.mark.parametrize("signature", GRID, ids=lambda one: one.name)
def test_every_signature_has_headline_columns_and_denominators(signature, recorded):
    columns = [f"{signature.name}.{name}" for name in signature.measure(recorded(seed=6).run)]
    assert signature.headline_columns(columns)
    assert any(column.startswith(f"{signature.name}.n_") for column in columns)
