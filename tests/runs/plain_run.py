"""A recorded run of a 2D world as dictionaries, and how its agents move; shares no code with the analysis."""

import cmath
import itertools
import json
import math
import statistics
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import lru_cache
from typing import Any

OFFSETS = {"up": (0, 1), "down": (0, -1), "left": (-1, 0), "right": (1, 0)}
Row = dict[str, Any]
Cell = tuple[int, int]
Measures = Iterator[tuple[str, float]]
Matrix = list[list[float]]


class Plain:
    """One run; with `readable_only` the decisions that could not be read do not count."""

    def __init__(self, folder: Any, *, readable_only: bool = False) -> None:
        self.world = folder.config()["world"]
        self.readable_only = readable_only
        self.ending = json.loads((folder.path / "run.json").read_text("utf-8"))
        rows = [json.loads(line) for line in (folder.path / "steps.jsonl").read_text("utf-8").splitlines()]
        self.rows = {(row["step"], row["agent"]): row for row in rows}
        self.heard = [json.loads(line) for line in (folder.path / "messages.jsonl").read_text("utf-8").splitlines()]
        self.steps, self.agents = range(1, max(row["step"] for row in rows) + 1), range(self.world["agents"])
        self.paths = {agent: self._path(agent) for agent in self.agents}

    def _path(self, agent: int) -> list[Cell]:
        rows = self.at(agent)
        return [(rows[0]["x"], rows[0]["y"]), *((row["x_next"], row["y_next"]) for row in rows)]

    def at(self, agent: int) -> list[Row]:
        return [self.rows[step, agent] for step in self.steps]

    def counts(self, row: Row) -> bool:
        return not self.readable_only or is_readable(row)

    def counts_message(self, row: Row) -> bool:
        return not self.readable_only or row["message_outcome"] in ("chosen", "repaired")

    @property
    def counted(self) -> list[Row]:
        """The steps whose action counts, in the order of the file."""
        return [row for row in self.rows.values() if self.counts(row)]

    def weight(self, step: int) -> int:
        """How many counted decisions led to the state after this step."""
        return sum(self.counts(self.rows[step, agent]) for agent in self.agents)

    def over_states(self, values: dict[int, float]) -> float:
        kept = {step: self.weight(step) for step in values if self.weight(step)}
        return over(sum(values[step] * weight for step, weight in kept.items()), sum(kept.values()))

    def place(self, cell: Cell) -> str | None:
        for place in self.world["places"]:
            if moves_into(cell, place) == 0:
                return str(place["name"])
        return None

    def stays(self, agent: int) -> list[str | None]:
        return [self.place(cell) for cell in self.paths[agent]]

    def legal(self, cell: Cell) -> dict[str, Cell]:
        moves = {name: (cell[0] + dx, cell[1] + dy) for name, (dx, dy) in OFFSETS.items()}
        return {name: to for name, to in moves.items() if max(map(abs, to)) <= self.world["half_size"]}


def is_readable(row: Row) -> bool:
    return row["outcome"] in ("chosen", "repaired")


def moves_into(cell: Cell, place: dict[str, Any]) -> int:
    offsets = (abs(cell[0] - place["center"][0]), abs(cell[1] - place["center"][1]))
    return sum(max(0, offset - extent) for offset, extent in zip(offsets, place["extent"], strict=True))


def manhattan(a: Cell, b: Cell) -> int:
    return abs(a[0] - b[0]) + abs(a[1] - b[1])


def over(part: float, whole: float) -> float:
    return part / whole if whole else math.nan


def average(values: Iterable[float]) -> float:
    kept = list(values)
    return over(sum(kept), len(kept))


def bits(counts: Iterable[int]) -> float:
    kept = [count for count in counts if count]
    total = sum(kept)
    return -sum(count / total * math.log2(count / total) for count in kept) if kept else math.nan


def different_pairs(things: Sequence[Any]) -> float:
    return average(a != b for a, b in itertools.combinations(things, 2))


def kaplan_meier_area(times: list[tuple[int, bool]], horizon: int) -> float:
    """Return the area under the estimate from 0 to the horizon; times with whether the event came then."""
    if not times:
        return math.nan
    area, alive = 0.0, 1.0
    for moment in range(horizon):
        at_risk = [time for time, _ in times if time >= moment]
        events = sum(seen and time == moment for time, seen in times)
        alive *= 1 - events / len(at_risk) if events else 1.0
        area += alive
    return area


def directions(counts: Counter[str]) -> dict[str, float]:
    total = sum(counts.values())
    vector = complex(counts["right"] - counts["left"], counts["up"] - counts["down"])
    return {
        "entropy": bits(counts.values()) / 2,
        "bits": bits(counts.values()),
        "kl": 2 - bits(counts.values()),
        "resultant_length": over(abs(vector), total),
        "mean_direction": math.degrees(cmath.phase(vector)) if vector else math.nan,
        **{f"share_{name}": over(counts[name], total) for name in OFFSETS},
    }


def cosine(a: str, b: str) -> int:
    return OFFSETS[a][0] * OFFSETS[b][0] + OFFSETS[a][1] * OFFSETS[b][1]


def movement(run: Plain) -> Measures:
    rows = run.counted
    made = Counter(row["direction"] for row in rows if row["moved"])
    asked = Counter(row["direction"] for row in rows if row["direction"])
    moves = [row["direction"] for row in rows if row["moved"]]
    yield "variety", different_pairs(moves)
    yield "alignment", average(cosine(a, b) for a, b in itertools.combinations(moves, 2))
    for name, value in directions(made).items():
        yield f"direction_{name}" if name in ("entropy", "bits", "kl") else name, value
    yield from ((f"asked_{name}", value) for name, value in directions(asked).items())
    legal = [run.legal((row["x"], row["y"])) for row in rows]
    walker = {name: average(over(name in ways, len(ways)) for ways in legal) for name in OFFSETS}
    yield from ((f"walker_share_{name}", value) for name, value in walker.items())
    total = sum(made.values())
    yield (
        "walker_kl",
        sum(n / total * math.log2(n / total / walker[name]) for name, n in made.items()) if made else math.nan,
    )
    yield from {"n_moves": total, "n_asked": sum(asked.values()), "n_decisions": len(rows)}.items()
    yield from drifts(run, rows)


def drifts(run: Plain, rows: list[Row]) -> Measures:
    def drift(distance: Callable[[Row, Cell], float], rows: list[Row]) -> float:
        return average(distance(row, after(row)) - distance(row, before(row)) for row in rows)

    beyond = beyond_blind(run)

    yield "drift_place_beyond_blind", average(beyond(row, lambda _, cell: to_place(run, cell)) for row in rows)
    yield "drift_agent_beyond_blind", average(beyond(row, lambda row, cell: to_agent(run, row, cell)) for row in rows)
    burning = [row for row in rows if any(fire["start"] <= row["step"] for fire in run.world["fires"])]
    yield "drift_place", drift(lambda row, cell: to_place(run, cell), rows)
    yield "drift_agent", drift(lambda row, cell: to_agent(run, row, cell), rows)
    yield (
        "drift_fire",
        drift(
            lambda row, cell: min(
                manhattan(cell, f["position"]) for f in run.world["fires"] if f["start"] <= row["step"]
            ),
            burning,
        ),
    )
    yield "n_burning", len(burning)


def beyond_blind(run: Plain) -> Callable[[Row, Callable[[Row, Cell], float]], float]:
    """Return the function of how much more a row's step changes a function of cells than a blind agent's would."""
    free = [row["direction"] for row in run.counted if row["moved"] and len(run.legal(before(row))) == 4]
    weight = {way: free.count(way) + 0.5 for way in OFFSETS}

    def beyond(row: Row, value: Callable[[Row, Cell], float]) -> float:
        if not row["moved"]:
            return 0.0
        legal, total = run.legal(before(row)), sum(weight[way] for way in run.legal(before(row)))
        return value(row, after(row)) - sum(weight[way] / total * value(row, to) for way, to in legal.items())

    return beyond


def before(row: Row) -> Cell:
    return row["x"], row["y"]


def after(row: Row) -> Cell:
    return row["x_next"], row["y_next"]


def to_place(run: Plain, cell: Cell) -> int:
    return min(moves_into(cell, place) for place in run.world["places"])


def to_agent(run: Plain, row: Row, cell: Cell) -> int:
    """Return the moves from a cell to where the nearest other agent stood before this step."""
    return min(manhattan(cell, before(run.rows[row["step"], i])) for i in run.agents if i != row["agent"])


def exploration(run: Plain) -> Measures:
    half, cells = run.world["half_size"], (2 * run.world["half_size"] + 1) ** 2
    paths = [[run.paths[agent][0], *(after(row) for row in run.at(agent) if run.counts(row))] for agent in run.agents]
    expected = expected_cells(half, len(run.steps))
    yield "coverage", average(len(set(path)) / cells for path in paths)
    yield "group_coverage", len({cell for path in paths for cell in path}) / cells
    yield "unique_ratio", average(len(set(path)) / len(path) for path in paths)
    yield "walker_ratio", average(len(set(path)) / expected[len(path) - 1][path[0]] for path in paths)
    yield "revisit_rate", average((len(path) - len(set(path))) / len(path) for path in paths)
    yield "visit_entropy", average(bits(Counter(path).values()) / math.log2(cells) for path in paths)
    spreads = [sum(statistics.pvariance(axis) for axis in zip(*path, strict=True)) for path in paths]
    yield "gyration", average(map(math.sqrt, spreads))
    yield from {"n_agents": len(paths), "n_states": average(map(len, paths)), "n_cells": cells}.items()


@lru_cache
def expected_cells(half: int, moves: int) -> list[dict[Cell, float]]:
    """Return the expected number of different cells of a walker by moves made, then by start."""
    grid = [(x, y) for x in range(-half, half + 1) for y in range(-half, half + 1)]
    ways = {(x, y): [(x + dx, y + dy) for dx, dy in OFFSETS.values() if (x + dx, y + dy) in set(grid)] for x, y in grid}
    found = [dict.fromkeys(grid, 0.0) for _ in range(moves + 1)]
    for target in grid:
        there = dict.fromkeys(grid, 0.0) | {target: 1.0}
        for made in range(moves + 1):
            if made:
                there = {cell: sum([there[to] for to in ways[cell]]) / len(ways[cell]) for cell in grid} | {target: 1.0}
            for cell, chance in there.items():
                found[made][cell] += chance
    return found


def hazard(run: Plain) -> Measures:
    fires = {fire["name"]: fire for fire in run.world["fires"]}
    rows = [row for row in run.counted if row["fires"]]

    def near(row: Row, cell: Cell) -> float:
        return min(math.dist(cell, fires[name]["position"]) for name in row["fires"])

    grew = {key(row): near(row, after(row)) > near(row, before(row)) for row in rows}
    legal = {key(row): run.legal(before(row)).values() for row in rows}
    walker = {key(row): average(near(row, to) > near(row, before(row)) for to in legal[key(row)]) for row in rows}
    moving = [row for row in rows if row["moved"]]
    yield "exposure", over(len(rows), len(run.counted))
    yield "away", average(grew.values())
    yield "walker_away", average(walker.values())
    beyond = beyond_blind(run)

    yield (
        "away_beyond_blind",
        average(beyond(row, lambda row, cell: near(row, cell) > near(row, before(row))) for row in rows),
    )
    yield "distance_beyond_blind", average(beyond(row, near) for row in rows)
    yield "away_moving", average(grew[key(row)] for row in moving)
    yield "difference_walker_moving", average(grew[key(row)] - walker[key(row)] for row in moving)
    yield "distance_change", average(near(row, after(row)) - near(row, before(row)) for row in rows)
    yield from matched(run, rows, grew)
    yield from {"n_decisions": len(run.counted), "n_exposed": len(rows), "n_exposed_moves": len(moving)}.items()
    yield from selection(run, moving, near)
    waits = []
    for agent in {row["agent"] for row in rows}:
        flags = [grew[key(row)] for row in rows if row["agent"] == agent]
        waits.append((flags.index(True) + 1, True) if any(flags) else (len(flags), False))
    # The curve is level behind its last step, so the area up to T needs no event at T itself.
    yield "latency", kaplan_meier_area(waits, len(run.steps))
    yield "n_exposed_agents", len(waits)


def key(row: Row) -> tuple[int, int]:
    return row["step"], row["agent"]


def matched(run: Plain, rows: list[Row], grew: dict[tuple[int, int], bool]) -> Measures:
    found, used = [], set()
    for row in rows:
        fire = min(
            (fire for fire in run.world["fires"] if fire["name"] in row["fires"]),
            key=lambda fire: math.dist(before(row), fire["position"]),
        )
        own = [
            other
            for other in run.counted
            if other["step"] < fire["start"]
            and not other["fires"]
            and int(math.dist(before(other), fire["position"])) == int(math.dist(before(row), fire["position"]))
        ]
        used |= {(key(other), fire["name"]) for other in own}
        if own:
            away = [
                math.dist(after(other), fire["position"]) > math.dist(before(other), fire["position"]) for other in own
            ]
            found.append((grew[key(row)], average(away)))
    a, c, n = sum(one for one, _ in found), sum(share for _, share in found), len(found)
    yield "difference_matched", over(a - c, n)
    logs = [math.log((away + 0.5) / (n + 0.5)) for away in (a, c)]
    yield "log_risk_ratio", logs[0] - logs[1] if n else math.nan
    odds = (a + 0.5) * (n - c + 0.5) / ((n - a + 0.5) * (c + 0.5))
    yield "log_odds_ratio", math.log(odds) if n else math.nan
    yield from {"n_matched": n, "n_controls": len(used)}.items()


def selection(run: Plain, rows: list[Row], near: Callable[[Row, Cell], float]) -> Measures:
    sets = []
    for row in rows:
        here = before(row)
        options = {
            way: [
                near(row, to) - near(row, here),
                to_place(run, to) - to_place(run, here),
                to_agent(run, row, to) - to_agent(run, row, here),
            ]
            for way, to in run.legal(here).items()
        }
        sets.append((options, row["direction"]))
    beta = newton(sets) if len(sets) >= 30 else [math.nan] * 3
    yield from zip(("beta_fire", "beta_place", "beta_agent"), beta, strict=True)
    yield "n_choices", len(sets)


def newton(sets: list[tuple[dict[str, list[float]], str]]) -> list[float]:
    """Return the greatest likelihood of a conditional logit with three covariates."""
    beta = [0.0] * 3
    for _ in range(40):
        gradient, hessian = [0.0] * 3, [[0.0] * 3 for _ in range(3)]
        for options, chosen in sets:
            weights = {way: math.exp(sum(b * v for b, v in zip(beta, x, strict=True))) for way, x in options.items()}
            shares = {way: weight / sum(weights.values()) for way, weight in weights.items()}
            mean = [sum(shares[way] * options[way][k] for way in options) for k in range(3)]
            for k in range(3):
                gradient[k] += options[chosen][k] - mean[k]
                for m in range(3):
                    second = sum(shares[way] * options[way][k] * options[way][m] for way in options)
                    hessian[k][m] += second - mean[k] * mean[m]
        whole = determinant(hessian)
        for k in range(3):
            replaced = [[gradient[r] if c == k else hessian[r][c] for c in range(3)] for r in range(3)]
            beta[k] += determinant(replaced) / whole
    return beta


def determinant(m: Matrix) -> float:
    return sum(
        m[0][i] * (m[1][(i + 1) % 3] * m[2][(i + 2) % 3] - m[1][(i + 2) % 3] * m[2][(i + 1) % 3]) for i in range(3)
    )
