"""One recorded run of a 2D world as dictionaries, straight from its JSON lines; shares no code with the analysis."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterable, Sequence
from typing import Any

OFFSETS = {"up": (0, 1), "down": (0, -1), "left": (-1, 0), "right": (1, 0)}
Row = dict[str, Any]
Cell = tuple[int, int]


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
        """Return the mean of values by state, weighted."""
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
        """Return where the moves lead that the edge allows."""
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
    """Return the share of pairs of things that are not the same."""
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
