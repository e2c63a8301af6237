"""The signatures of warnings, of repeated actions and of trips, once more with plain loops over the records."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator

import networkx as nx

from foundry import seeding
from plain_run import Plain, average, bits, different_pairs, kaplan_meier_area, over

WARNINGS = {"fire1 near me", "火事だ、逃げて", "there is smoke"}
OPPOSITE = {"up": "down", "down": "up", "left": "right", "right": "left"}
Measures = Iterator[tuple[str, float]]
Sent = set[tuple[int, int]]


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
