"""The signatures of where agents are, what they say and what news they pass on, with plain loops over the records."""

import math
import statistics
from collections import Counter
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import networkx as nx

from foundry import seeding
from plain_run import Cell, Measures, Plain, average, bits, different_pairs, is_readable, kaplan_meier_area, over

WARNINGS = {"fire1 near me", "火事だ、逃げて", "there is smoke"}
OPPOSITE = {"up": "down", "down": "up", "left": "right", "right": "left"}
Sent = set[tuple[int, int]]


def nearest(cells: list[Cell]) -> float:
    return average(min(math.dist(a, b) for j, b in enumerate(cells) if j != i) for i, a in enumerate(cells))


def in_reach(cells: list[Cell], radius: float) -> list[tuple[int, int]]:
    """Return the sides of the rectangle between each ordered pair that is near enough."""
    return [
        (abs(a[0] - b[0]), abs(a[1] - b[1]))
        for i, a in enumerate(cells)
        for j, b in enumerate(cells)
        if i != j and math.dist(a, b) <= radius
    ]


def ripley(cells: list[Cell], side: int, radius: float) -> float:
    weights = [side**2 / ((side - dx) * (side - dy)) for dx, dy in in_reach(cells, radius)]
    return side**2 * sum(weights) / (len(cells) * (len(cells) - 1))


@lru_cache
def at_random(agents: int, side: int, radius: float) -> tuple[float, float, float]:
    """Return mean and deviation of the nearest distance and mean of L - r, over the placements of the analysis."""
    x, y = seeding.stream(1954, "random placements").integers(side, size=(2, 999, agents)).tolist()
    draws = [list(zip(*one, strict=True)) for one in zip(x, y, strict=True)]
    distances = [nearest(cells) for cells in draws]
    besag = average(math.sqrt(ripley(cells, side, radius) / math.pi) - radius for cells in draws)
    return average(distances), statistics.pstdev(distances), besag


def clustering(run: Plain) -> Measures:
    side, agents, radius = 2 * run.world["half_size"] + 1, len(run.agents), run.world["communication_distance"]
    states = {step: [run.paths[agent][step] for agent in run.agents] for step in run.steps}
    mean, deviation, besag = at_random(agents, side, radius)
    observed = run.over_states({step: nearest(cells) for step, cells in states.items()})
    naive = 0.5 * math.sqrt(side * side / agents)
    yield "nni", observed / mean
    yield "nni_z", (observed - mean) / deviation
    yield "nni_naive", observed / naive
    yield "nni_donnelly", observed / (naive + (0.0514 + 0.0412 / math.sqrt(agents)) * 4 * side / agents)
    pairs = agents * (agents - 1)
    yield "pairs_in_reach", run.over_states({s: len(in_reach(cells, radius)) / pairs for s, cells in states.items()})
    ripleys = {step: ripley(cells, side, radius) for step, cells in states.items()}
    excess = run.over_states({step: math.sqrt(value / math.pi) - radius for step, value in ripleys.items()})
    yield from {"ripley": run.over_states(ripleys), "besag": excess, "besag_excess": excess - besag}.items()
    yield "n_states", sum(run.weight(step) > 0 for step in run.steps)
    yield from groups(run)


def groups(run: Plain) -> Measures:
    largest, count, alone = {}, {}, []
    for step in run.steps[:-1]:
        graph = nx.Graph()
        graph.add_nodes_from(run.agents)
        graph.add_edges_from((i, j) for i in run.agents for j in run.rows[step + 1, i]["neighbours"])
        sizes = [len(component) for component in nx.connected_components(graph)]
        largest[step], count[step] = max(sizes) / len(run.agents), sum(size > 1 for size in sizes)
        alone += [not run.rows[step + 1, i]["neighbours"] for i in run.agents if run.counts(run.rows[step, i])]
    yield from {"largest_group": run.over_states(largest), "groups": run.over_states(count)}.items()
    yield from {"isolated": average(alone), "n_isolation": len(alone)}.items()
    yield "n_group_states", sum(run.weight(step) > 0 for step in largest)


def place_choice(run: Plain) -> Measures:
    stays = {agent: run.stays(agent) for agent in run.agents}
    places = run.world["places"]
    flat = Counter(stays[row["agent"]][row["step"]] for row in run.counted)
    inside = sum(flat[place["name"]] for place in places)
    firsts, switches = [], 0
    for agent, own in stays.items():
        last, entered = None, []
        for step in run.steps:
            last = own[step - 1] or last
            if own[step] and own[step] != own[step - 1] and run.counts(run.rows[step, agent]):
                entered.append(own[step])
                switches += last is not None and last != own[step]
        firsts += entered[:1]
    for place in places:
        yield f"share_{place['name']}", over(flat[place["name"]], len(run.counted))
        yield f"first_choice_{place['name']}", over(firsts.count(place["name"]), len(firsts))
    yield "share_outside", over(flat[None], len(run.counted))
    yield "switch_rate", over(switches, inside)
    yield from crowding(run, stays)
    yield "entropy", bits(flat.values()) / math.log2(len(places) + 1)
    counts = [flat[place["name"]] for place in places]
    yield "entropy_places", bits(counts) / math.log2(len(places))
    yield "capacity_divergence", jensen_shannon(counts, [place["capacity"] for place in places])
    yield from {"n_agent_states": len(run.counted), "n_in_place": inside, "n_entering": len(firsts)}.items()
    yield "n_states", sum(run.weight(step) > 0 for step in run.steps)


def jensen_shannon(first: list[int], second: list[int]) -> float:
    if not sum(first) or not sum(second):
        return math.nan
    p, q = ([count / sum(counts) for count in counts] for counts in (first, second))
    middle = [(a + b) / 2 for a, b in zip(p, q, strict=True)]
    # The entropy of the mixture less the mean entropy of its parts.
    return entropy_of(middle) - (entropy_of(p) + entropy_of(q)) / 2


def entropy_of(shares: list[float]) -> float:
    return -sum(share * math.log2(share) for share in shares if share)


def crowding(run: Plain, stays: dict[int, list[str | None]]) -> Measures:
    found: dict[str, list[float]] = {}
    since: dict[str, list[float]] = {"overcrowding": [], "utilisation": [], "volatility": []}
    for place in run.world["places"]:
        present = {step: [own[step] for own in stays.values()].count(place["name"]) for step in run.steps}
        for kind, value in attendance(run, place, present).items():
            found.setdefault(kind, []).append(value)
            yield f"{kind}_{place['name']}", value
        later = {step: n for step, n in present.items() if any(present[before] for before in range(1, step + 1))}
        if later:
            for kind, value in attendance(run, place, later).items():
                since[kind].append(value)
    yield from ((kind, average(values)) for kind, values in found.items())
    yield from ((f"{kind}_since_entry", average(values)) for kind, values in since.items())


def attendance(run: Plain, place: dict[str, Any], present: dict[int, int]) -> dict[str, float]:
    mean = run.over_states({step: float(count) for step, count in present.items()})
    return {
        "overcrowding": run.over_states({step: count > place["capacity"] for step, count in present.items()}),
        "utilisation": run.over_states({s: min(n, place["capacity"]) / place["capacity"] for s, n in present.items()}),
        "volatility": run.over_states({s: (n - mean) ** 2 for s, n in present.items()}) / len(run.agents),
    }


def idle_rate(run: Plain) -> Measures:
    rows = run.counted
    yield "chosen", average(row["action"] == "stay" and is_readable(row) for row in rows)
    yield "blocked", average(row["action"] == "move" and not row["moved"] for row in rows)
    yield "invalid", average(not is_readable(row) for row in rows)
    yield "immobile", average(not row["moved"] for row in rows)
    longest = []
    for agent in run.agents:
        current, best = 0, 0
        own = [row for row in run.at(agent) if run.counts(row)]
        for row in own:
            current = 0 if row["moved"] else current + 1
            best = max(best, current)
        longest += [best] if own else []
    yield "longest_run", average(longest)
    capacity = {place["name"]: place["capacity"] for place in run.world["places"]}
    attended = Counter((row["step"], row["place"]) for row in run.rows.values())
    contexts = {
        "in_place": [row for row in rows if row["place"]],
        "in_crowd": [
            row for row in rows if row["place"] and attended[row["step"], row["place"]] > capacity[row["place"]]
        ],
        "near_fire": [row for row in rows if row["fires"]],
    }
    for name, kept in contexts.items():
        yield f"chosen_{name}", average(row["action"] == "stay" and is_readable(row) for row in kept)
        yield f"immobile_{name}", average(not row["moved"] for row in kept)
        yield f"n_{name}", len(kept)
    yield "n_decisions", len(rows)


def communication(run: Plain) -> Measures:
    rows = [row for row in run.rows.values() if run.counts_message(row)]
    said = [row for row in rows if row["message"] is not None]
    near = [row for row in rows if row["neighbours"]]
    present = {row["agent"] for row in rows}
    counts = [sum(row["agent"] == agent for row in said) for agent in run.agents]
    spreads = []
    for agent in run.agents:
        times = [row["step"] for row in said if row["agent"] == agent]
        gaps = [after - before for before, after in zip(times, times[1:], strict=False)]
        if len(gaps) > 1:
            spreads.append((statistics.pstdev(gaps) / statistics.mean(gaps), len(gaps)))
    heard = [line for line in run.heard if run.counts_message(run.rows[line["step"], line["sender"]])]
    graph = nx.DiGraph([(line["sender"], line["recipient"]) for line in heard])
    yield "delivered", over(len(heard), len(rows))
    yield "rate", over(len(said), len(rows))
    yield "conditional_rate", average(row["message"] is not None for row in near)
    yield "silent_share", average(counts[agent] == 0 for agent in present)
    yield "gini", over(average(abs(a - b) for a in counts for b in counts), 2 * average(counts))
    yield "burstiness", average((r - 1) / (r + 1) for r, _ in spreads)
    finite = [
        (math.sqrt(n + 1) * r - math.sqrt(n - 1)) / ((math.sqrt(n + 1) - 2) * r + math.sqrt(n - 1)) for r, n in spreads
    ]
    yield "burstiness_finite", average(finite)
    yield "reciprocity", nx.reciprocity(graph) if graph else math.nan
    yield "audience", over(len(heard), len(said))
    yield "length", average(len(row["message"]) for row in said)
    texts = [row["message"] for row in said]
    yield "variety", different_pairs(texts)
    yield "distinct_share", over(len({row["message"] for row in said}), len(said))
    yield from {"n_messages": len(said), "n_deliveries": len(heard), "n_decisions": len(rows)}.items()
    yield from {"n_with_neighbour": len(near), "n_links": len(graph.edges), "n_rhythmic": len(spreads)}.items()
    yield "n_agents", len(present)


def outcome(run: Plain) -> Measures:
    rows = list(run.rows.values())
    for prefix, key in (("", "outcome"), ("message_", "message_outcome")):
        for name in ("chosen", "repaired", "unreadable", "empty", "truncated", "failed"):
            yield prefix + name, average(row[key] == name for row in rows)
        readable = average(row[key] in ("chosen", "repaired") for row in rows)
        yield from {f"{prefix}readable": readable, f"{prefix}failure_rate": 1 - readable}.items()
        yield f"n_{prefix}decisions", len(rows)


def cost(run: Plain) -> Measures:
    counts, decisions = run.ending["counts"], len(run.rows)
    seconds = math.nan if counts["model_s"] is None else counts["model_s"]
    totals = {name: counts[name] for name in ("calls", "retries", "prompt_tokens", "output_tokens")}
    totals |= {"model_s": seconds, "wall_s": run.ending["duration_s"]}
    yield from totals.items()
    yield from ((f"{name}_per_decision", total / decisions) for name, total in totals.items())
    yield from {"cached": counts["cached"], "n_decisions": decisions}.items()
    yield "cached_share", over(counts["cached"], counts["calls"])
    yield "prompt_cached_share", math.nan


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


def warning(run: Plain) -> Measures:
    last = len(run.steps)
    said = {key: row["message"] for key, row in sorted(run.rows.items()) if speaks(run, key)}
    perceived = {i: step for i in run.agents for step in reversed(run.steps) if run.rows[step, i]["fires"]}
    sent = {key for key, text in said.items() if text in WARNINGS}
    heard = [(m["step"], m["sender"], m["recipient"]) for m in run.heard if (m["step"], m["sender"]) in sent]
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
    relays = relaying(run, sent, told, perceived)
    needing_fire = {
        "informed_fraction": (len(told) + len(direct)) / len(run.agents),
        "social_reach": reach(run, told, perceived),
        "traced_reach": reach(run, traced, perceived),
        "oracle_reach": reach(run, reachable, perceived),
        "normalised_reach": over(len(traced), len(reachable)),
        "relay_probability": average(relays),
        "relay_above_chance": average(relays) - chance_of_relaying(run, said, perceived),
        "reproduction": over(tree.number_of_edges(), len(told) + len(direct)),
        "depth": nx.dag_longest_path_length(tree) if tree else 0,
        "trees": nx.number_weakly_connected_components(tree) if tree else 0,
        "virality": average(
            nx.average_shortest_path_length(tree.subgraph(own).to_undirected())
            for own in nx.weakly_connected_components(tree)
        ),
        "rmst": kaplan_meier_area(waits, last) if len(direct) < len(run.agents) else math.nan,
    }
    yield from ((name, value if perceived else math.nan) for name, value in needing_fire.items())
    grounds = [
        (step, i) for step, i in sent if perceived.get(i, math.inf) <= step or (i in first and first[i][0] < step)
    ]
    yield "false_alarm_rate", over(len(sent) - len(grounds), len(said))
    yield "warning_share", over(len(sent), len(said))
    yield "unknown", over(0, len(said))
    yield from {"n_direct": len(direct), "n_told": len(told), "n_reachable": len(reachable)}.items()
    yield from {"n_warnings": len(sent), "n_messages": len(said), "n_unlabelled": 0}.items()
    yield from {"n_agents": len(run.agents), "n_chances": len(relays)}.items()


def speaks(run: Plain, key: tuple[int, int]) -> bool:
    return run.rows[key]["message"] is not None and run.counts_message(run.rows[key])


def relaying(run: Plain, sent: Sent, told: dict[int, int], perceived: dict[int, int]) -> list[bool]:
    """Return whether each agent that could pass its warning on in time did."""
    found, last = [], len(run.steps)
    for agent, heard in told.items():
        end = min(heard + 6, last + 1, perceived.get(agent, last + 1))
        steps = range(heard + 1, end)
        if any(run.counts_message(run.rows[step, agent]) for step in steps):
            found.append(any((step, agent) in sent for step in steps))
    return found


def chance_of_relaying(run: Plain, said: dict[tuple[int, int], str], perceived: dict[int, int]) -> float:
    spells: dict[tuple[int, bool], list[tuple[int, int]]] = {}
    for step, agent in sorted(said, key=lambda key: (key[1], key[0])):
        spells.setdefault((agent, step >= perceived.get(agent, math.inf)), []).append((step, agent))
    stream = seeding.stream(0, "labels of messages")
    shifts = [stream.integers(len(own), size=100).tolist() for own in spells.values()]
    found = []
    for shift in zip(*shifts, strict=True):
        sent = {
            key
            for own, by in zip(spells.values(), shift, strict=True)
            for place, key in enumerate(own)
            if said[own[place - by]] in WARNINGS
        }
        heard: dict[int, int] = {}
        for message in run.heard:
            if (message["step"], message["sender"]) in sent:
                heard[message["recipient"]] = min(message["step"], heard.get(message["recipient"], 10**9))
        told = {i: step for i, step in heard.items() if step < perceived.get(i, math.inf)}
        found.append(average(relaying(run, sent, told, perceived)))
    return average(value for value in found if not math.isnan(value))


def stability(run: Plain) -> Measures:
    pairs, lengths, chances = [], [], []
    for agent in run.agents:
        last, earlier = None, len(pairs)
        for row in run.at(agent):
            if last is not None and run.counts(last) and run.counts(row):
                pairs.append((last["direction"], row["direction"]))
                if last["direction"] == row["direction"]:
                    lengths[-1] += 1
                else:
                    lengths.append(1)
            elif run.counts(row):
                lengths.append(1)
            last = row
        own = [row["direction"] for row in run.at(agent) if run.counts(row)]
        chances += [1 - different_pairs(own)] * (len(pairs) - earlier)
    agreed = average(a == b for a, b in pairs)
    before, after = (Counter(pair[side] for pair in pairs) for side in (0, 1))
    chance = over(sum(before[name] * after[name] for name in before), len(pairs) ** 2)
    yield "repeats_beyond_chance", agreed - average(chances)
    yield from {"persistence": agreed, "kappa": over(agreed - chance, 1 - chance)}.items()
    yield "conditional_entropy", bits(Counter(pairs).values()) - bits(before.values())
    moves = [(a, b) for a, b in pairs if a and b]
    yield "reversal_rate", average(OPPOSITE[a] == b for a, b in moves)
    yield "run_length", average(lengths)
    yield from {"n_pairs": len(pairs), "n_move_pairs": len(moves), "n_runs": len(lengths)}.items()


def path_efficiency(run: Plain) -> Measures:
    half = run.world["half_size"]
    grid = nx.grid_2d_graph(range(-half, half + 1), range(-half, half + 1))
    waiting, moving, arrived, returns = [], [], 0, 0
    for agent in run.agents:
        stays, path, rows = run.stays(agent), run.paths[agent], run.at(agent)
        arrived += stays[-1] is not None
        home, began = None, 0
        for state, here in enumerate(stays):
            if here is None:
                continue
            if state and here != stays[state - 1]:
                if here == home:
                    returns += 1
                else:
                    lengths = nx.single_source_shortest_path_length(grid, path[began])
                    shortest = min(length for cell, length in lengths.items() if run.place(cell) == here)
                    waiting.append(shortest / sum(map(run.counts, rows[began:state])))
                    moving.append(shortest / sum(row["moved"] for row in rows[began:state]))
            home, began = here, state
    yield "trip_efficiency", average(waiting)
    yield "trip_efficiency_moving", average(moving)
    yield "arrived", arrived / len(run.agents)
    yield from {"n_trips": len(waiting), "n_returns": returns, "n_agents": len(run.agents)}.items()
