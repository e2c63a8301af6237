"""Gives the page a run of a 2D world as lists of small numbers."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Annotated, Any

import msgspec

from foundry.errors import RecordError
from foundry.records import GridStep
from foundry.storing.store import RunFolder, lines_of
from foundry.viewer.grid.by_step import GridByStep
from foundry.viewer.lines import StepLines, lines_of_agent
from foundry.viewer.run_view import OUTCOMES, UNDECIDED, RunView

DIRECTIONS = ("stay", "up", "down", "left", "right")
DEEDS = ("gather", "share", "attack", "reproduce")
"""The actions besides moves that agents have in a world with energy."""
SAID, MOVED, ALARMED, AWAY = 1, 2, 4, 8
"""Values that are added up to the number `flags`: the agent spoke, moved, perceived a fire, was absent."""
DECISIONS_PER_CHUNK = 20_000
_OUTCOME_CODES = {name: code for code, name in enumerate(OUTCOMES)}
_ACTION_CODES: dict[str | None, int] = {name: code for code, name in enumerate((*DIRECTIONS, *DEEDS))}
_DELIVERY = re.compile(rb'^\{"step":(\d+),"sender":(\d+),"recipient":(\d+),', re.MULTILINE)
_READ_STEP = msgspec.json.Decoder(GridStep).decode


class _Place(msgspec.Struct):
    name: str


class _Fire(msgspec.Struct):
    name: str
    start: int
    position: tuple[float, float]


class _Reproduction(msgspec.Struct):
    most: int


class _Grid(msgspec.Struct):
    agents: Annotated[int, msgspec.Meta(ge=1)]
    half_size: Annotated[int, msgspec.Meta(ge=0)]
    places: list[_Place]
    fires: list[_Fire] | None = None
    reproduction: _Reproduction | None = None


class _Cell(msgspec.Struct):
    """A line of `burning.jsonl` (a cell that catches fire) or of `food.jsonl` (a cell, and how much food is in it)."""

    step: int
    x: int
    y: int
    amount: int = 1


FURNITURE = ("walls", "exits", "zones", "food", "energy")
"""Names of things that only some worlds have and that the page draws."""


class GridView(RunView):
    """The view of a run of a 2D world; `foundry/viewer/README.md` lists the keys of its results."""

    def __init__(self, folder: RunFolder, *, decisions_per_chunk: int = 10, trusted: Sequence[str] = ()) -> None:
        super().__init__(folder, decisions_per_chunk=decisions_per_chunk, trusted=trusted)
        try:
            self._grid = msgspec.convert(folder.world(), _Grid)
        except msgspec.ValidationError as error:
            raise RecordError(f"The world of run '{folder.id}' cannot be shown: {error}") from error
        self.steps_per_chunk = max(1, min(50, DECISIONS_PER_CHUNK // self.agents))
        self._places = {place["name"]: index for index, place in enumerate(self.world["places"])}
        self._cells = {
            name: StepLines(folder.stream_path(name)) for name in ("burning", "food") if name in folder.declared.streams
        }
        self._come_and_go = "lost" in folder.declared.streams.get("steps", ())
        self._by_step: GridByStep | None = None

    @property
    def agents(self) -> int:
        """Maximum number of agents in the run, including agents that may be born."""
        births = self._grid.reproduction
        return self._grid.agents if births is None else max(self._grid.agents, births.most)

    @property
    def done(self) -> int:
        """Number of completely recorded steps.

        If agents come and go, the last step may lack lines, so it counts only when the run has ended.
        """
        if not self._come_and_go:
            return super().done
        return self.steps.last[0] if self.folder.ended else max(0, self.steps.last[0] - 1)

    def about_world(self) -> dict[str, Any]:
        """Return the size of the grid, its places and fires, and the optional parts that the page draws."""
        keys = ("half_size", "places", "fires", "communication_distance")
        world = self.folder.world()  # positions may have been recorded in the meantime
        further = {key: world[key] for key in FURNITURE if world.get(key)}
        return {key: world.get(key) for key in keys} | {"directions": DIRECTIONS} | further

    def frames(self, first: int, last: int) -> dict[str, Any]:
        """Return positions, actions, outcomes and neighbours of agents, and deliveries, from step `first` to `last`."""
        rows = self._rows(first, last)
        links: list[list[int]] = [[] for _ in range(first, last + 1)]
        for row in rows:
            for other in row.neighbours:
                if other > row.agent:
                    links[row.step - first] += (row.agent, other)
        rooms = [(row.step - first) * self.agents + row.agent for row in rows]
        size = (last - first + 1) * self.agents

        def dense(values: Iterable[int], nothing: int = 0, *, ends: Iterable[int] = ()) -> list[int]:
            """Return a list of the values by step and agent; with `ends`, also the values after the last step."""
            after = list(ends)
            cells = [nothing] * (size + (self.agents if after else 0))
            for room, end in zip(rooms, after, strict=False):
                cells[room + self.agents] = end
            for room, value in zip(rooms, values, strict=True):
                cells[room] = value
            return cells

        return {
            "first": first,
            "last": last,
            "x": dense((row.x for row in rows), ends=(row.x_next for row in rows)),
            "y": dense((row.y for row in rows), ends=(row.y_next for row in rows)),
            "action": dense(self._code(_ACTION_CODES, row.direction or row.action, row) for row in rows),
            "outcome": dense(_OUTCOME_CODES[row.outcome] for row in rows),
            "message_outcome": dense(_OUTCOME_CODES[row.message_outcome] for row in rows),
            "flags": dense(map(_flags, rows), AWAY),
            "place": dense((-1 if row.place is None else self._code(self._places, row.place, row) for row in rows), -1),
            "links": links,
            "deliveries": self._deliveries(first, last),
            **{name: self._changes(lines, first, last) for name, lines in self._cells.items()},
        }

    def _changes(self, lines: StepLines, first: int, last: int) -> list[list[int]]:
        """Return, for each step, the changed cells of a resource as x, y, amount, x, y, amount, and so on.

        The first list contains all changes before step `first`.
        """
        lines.grow()
        changes: list[list[int]] = [[] for _ in range(first, last + 2)]
        for cell in lines_of(lines.read(0, last), _Cell, lines.path):
            changes[max(0, cell.step - first + 1)] += (cell.x, cell.y, cell.amount)
        return changes

    def _code(self, codes: Mapping[Any, int], name: str | None, row: GridStep) -> int:
        if name not in codes:
            known = ", ".join(str(code) for code in codes)
            where = f"{self.steps.path}: step {row.step}, agent {row.agent}"
            raise RecordError(f"{where}: '{name}' is unknown. It must be one of {known}.")
        return codes[name]

    def marks(self, first: int, last: int) -> dict[str, list[int]]:
        """Return for each step how many decisions were unreadable or repaired, and how many agents spoke and moved."""
        marks = {name: [0] * max(0, last - first + 1) for name in ("undecided", "repaired", "said", "moved")}
        for row in self._rows(first, last):
            at = row.step - first
            outcomes = (row.outcome, row.message_outcome)
            marks["undecided"][at] += sum(outcome in UNDECIDED for outcome in outcomes)
            marks["repaired"][at] += sum(outcome == "repaired" for outcome in outcomes)
            marks["said"][at] += row.message is not None
            marks["moved"][at] += row.moved
        return marks

    def counted(self, first: int, last: int) -> Iterator[tuple[int, Mapping[str, float]]]:
        """Yield, for each agent and step, the agent's id and its numbers of messages, moves and unreadable replies."""
        for row in self._rows(first, last):
            failures = sum(outcome in UNDECIDED for outcome in (row.outcome, row.message_outcome))
            yield row.agent, {"messages": int(row.message is not None), "moves": int(row.moved), "failures": failures}

    def by_step(self, first: int, last: int) -> dict[str, list[float | None]]:
        """Return the curves that `GridByStep` computes: the values of each, from step `first` to `last`."""
        counted = self._by_step or GridByStep(self.folder.world(), self.is_warning, steady=not self._come_and_go)
        self._by_step = counted
        while (known := counted.done) < last:
            until = min(known + self.steps_per_chunk, self.done)
            counted.take(known + 1, self._rows(known + 1, until), self._deliveries(known + 1, until))
        return {name: values[first - 1 : last] for name, values in counted.values.items()}

    def texts(self, first: int, last: int) -> list[tuple[int, int, str]]:
        """Return step, sender and text of each message in the given steps."""
        return [(row.step, row.agent, row.message) for row in self._rows(first, last) if row.message is not None]

    def track(self, agent: int) -> dict[str, Any]:
        """Return the agent's cells, outcomes and persona. In the first cell, the agent stood before the first step."""
        spans = ((first, min(first + self.steps_per_chunk, self.done + 1) - 1) for first in self._firsts())
        lines = [line for span in spans for line in lines_of_agent(self.steps.read(*span), agent)]
        return self._track([_READ_STEP(line) for line in lines], self.personas().get(agent, {}))

    def all_tracks(self) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield each agent with what `track` returns for it, but read the records only once for all agents."""
        rows: list[list[GridStep]] = [[] for _ in range(self.agents)]
        for first in self._firsts():
            for row in self._rows(first, min(first + self.steps_per_chunk - 1, self.done)):
                rows[row.agent].append(row)
        personas = self.personas()
        for agent, mine in enumerate(rows):
            yield agent, self._track(mine, personas.get(agent, {}))

    def _firsts(self) -> range:
        return range(1, self.done + 1, self.steps_per_chunk)

    def _track(self, rows: Sequence[GridStep], persona: Mapping[str, str]) -> dict[str, Any]:
        """Return an agent's path by step: its first cell before it arrives, and its last cell after it has left."""
        final = rows[-1:]
        before = [rows[0].x, rows[0].y] if rows else [0, 0]
        early, late = (rows[0].step - 1, self.done - rows[-1].step) if rows else (0, self.done)

        def padded(values: Iterable[int], nothing: int) -> list[int]:
            return [nothing] * early + list(values) + [nothing] * late

        end = [(row.x_next, row.y_next) for row in final]
        return {
            "x": [before[0]] * early + [row.x for row in rows] + [x for x, _ in end] * (late + 1),
            "y": [before[1]] * early + [row.y for row in rows] + [y for _, y in end] * (late + 1),
            "outcome": padded((_OUTCOME_CODES[row.outcome] for row in rows), 0),
            "message_outcome": padded((_OUTCOME_CODES[row.message_outcome] for row in rows), 0),
            "flags": padded(map(_flags, rows), AWAY),
            "persona": persona,
        }

    def _rows(self, first: int, last: int) -> Sequence[GridStep]:
        """Return the records of the given steps, sorted by step and agent. An absent agent has no record in a step.

        Raises:
            RecordError: there is not one record per step and agent.
        """
        rows = self.read_steps(first, last, GridStep)
        if self._come_and_go:
            return rows
        shape = (range(first, last + 1), range(self.agents))
        if [(row.step, row.agent) for row in rows] != [(step, agent) for step in shape[0] for agent in shape[1]]:
            raise RecordError(f"{self.steps.path}: steps {first} to {last} must have one line per step and agent.")
        return rows

    def _deliveries(self, first: int, last: int) -> list[list[int]]:
        self.messages.grow()
        deliveries: list[list[int]] = [[] for _ in range(first, last + 1)]
        for step, sender, recipient in _DELIVERY.findall(self.messages.read(first, last)):
            deliveries[int(step) - first] += (int(sender), int(recipient))
        return deliveries


def _flags(row: GridStep) -> int:
    return SAID * (row.message is not None) + MOVED * row.moved + ALARMED * bool(row.fires)
