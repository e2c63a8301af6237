"""A run of any form, read by the keys that all decisions have and by its world's declaration."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import msgspec

from foundry.storing.store import RunFolder, lines_of
from foundry.viewer.any.drawing import Drawing
from foundry.viewer.any.streams import Curves, OwnStream, curves_of, streams_of
from foundry.viewer.lines import DecisionLines, lines_of_agent
from foundry.viewer.run_view import MARKS_PER_BLOCK, OUTCOMES, PNG, UNDECIDED, Resource, RunView, parts_of, raw

LINES_PER_CHUNK = 20_000
_OUTCOME_CODES: dict[str | None, int] = {name: code for code, name in enumerate(OUTCOMES)}
_ENCODE = msgspec.json.Encoder().encode
_MARKS = ("undecided", "repaired", "said")


class Decision(msgspec.Struct, frozen=True, gc=False):
    """A line of `steps.jsonl` with the keys that all forms share. Records of unknown worlds may lack some keys."""

    step: int
    agent: int
    kind: str | None = None
    action: Any = None
    outcome: str | None = None
    utility: Any = None
    message: Any = None


class AnyView(RunView):
    """See `foundry/viewer/README.md` for the keys of results."""

    def __init__(self, folder: RunFolder, *, decisions_per_chunk: int = 10, trusted: Sequence[str] = ()) -> None:
        super().__init__(folder, decisions_per_chunk=decisions_per_chunk, trusted=trusted)
        self.steps: DecisionLines = DecisionLines(folder.stream_path("steps"))
        self.drawing = Drawing(folder, trusted)
        self._streams: tuple[OwnStream, ...] = streams_of(folder)
        self._curves: tuple[Curves, ...] = curves_of(folder.declared, self.steps, self._streams)

    @property
    def agents(self) -> int:
        """Number of agents that have a decision or a persona so far."""
        self.steps.grow()
        return max(self.steps.agents, *(agent + 1 for agent in self.personas()), 0)

    @property
    def done(self) -> int:
        """Number of complete steps.

        Before the run has ended, a last step with fewer lines than the first step is not complete.
        """
        step, count = self.steps.last
        return step if count >= self.steps.in_first or self.folder.ended else step - 1

    def progress(self, *, running: bool) -> dict[str, Any]:
        """Return the progress of the run. The page loads the run again if the value `beginning` changes."""
        state = super().progress(running=running)
        self._fit()
        return state | {"beginning": f"{state['beginning']} {self.agents} {self.steps.in_first}"}

    def _fit(self) -> None:
        self.steps_per_chunk = max(1, min(50, LINES_PER_CHUNK // max(1, self.steps.in_first)))

    def about_world(self) -> dict[str, Any]:
        """Return what the world declares about its records: actions, keys, record files and curves."""
        self._fit()
        declared = self.folder.declared
        return {
            "actions": declared.actions,
            "keys": declared.streams.get("steps", {}),
            "streams": [stream.told for stream in self._streams],
            "curves": [curve.told for curve in self._curves],
        }

    def frames(self, first: int, last: int) -> dict[str, Any]:
        """Return the raw records."""
        return {"first": first, "last": last, "rows": raw(self.steps.read(first, last).splitlines())}

    def lanes(self, block: int) -> dict[str, Any]:
        """Return the decisions of a block of steps as columns: one list per key, in the order of the decisions."""
        first, last = self.chunk(block, MARKS_PER_BLOCK)
        rows = self._rows(first, last)
        return {
            "first": first,
            "last": last,
            "step": [row.step for row in rows],
            "agent": [row.agent for row in rows],
            "kind": [row.kind for row in rows],
            "action": [_plain(row.action) for row in rows],
            "outcome": [_OUTCOME_CODES.get(row.outcome, -1) for row in rows],
            "utility": [row.utility for row in rows],
        }

    def curves(self, block: int) -> dict[str, Any]:
        """Return the values of all curves in a block of steps; `about_world` lists these curves in the same order."""
        first, last = self.chunk(block, MARKS_PER_BLOCK)
        return {"first": first, "last": last, "values": [curve.values(first, last) for curve in self._curves]}

    def marks(self, first: int, last: int) -> dict[str, list[int]]:
        """Return how many decisions of each step are undecided, are repaired, and contain a message."""
        return _marks(self._rows(first, last), first, last)

    def counted(self, first: int, last: int) -> Iterator[tuple[int, Mapping[str, float]]]:
        """Yield, for each decision, its agent and its numbers: messages, failures, and the utility if it has one."""
        for row in self._rows(first, last):
            counts = {"messages": int(isinstance(row.message, str)), "failures": int(row.outcome in UNDECIDED)}
            yield row.agent, counts | ({"utility": row.utility} if isinstance(row.utility, int | float) else {})

    def by_step(self, first: int, last: int) -> dict[str, list[float | None]]:
        """Return, for each step, the mean utility (if utilities are recorded) and the mean of each curve."""
        utilities: dict[int, list[float]] = {}
        for row in self._rows(first, last):
            if isinstance(row.utility, int | float):
                utilities.setdefault(row.step, []).append(row.utility)
        series = (
            {"utility (mean)": [_mean(utilities.get(step)) for step in range(first, last + 1)]} if utilities else {}
        )
        for curve in self._curves:
            for key, values in zip(curve.keys, curve.values(first, last), strict=True):
                series[key if key == curve.name else f"{key} ({curve.name})"] = values["mean"]
        return series

    def texts(self, first: int, last: int) -> list[tuple[int, int, str]]:
        """Return the messages."""
        rows = self._rows(first, last)
        return [(row.step, row.agent, row.message) for row in rows if isinstance(row.message, str)]

    def track(self, agent: int) -> dict[str, Any]:
        """Return the persona of an agent and, for each step, marks: for example, that its reply was unreadable."""
        spans = self._spans()
        lines = [line for span in spans for line in lines_of_agent(self.steps.read(*span), agent)]
        rows = lines_of(b"\n".join(lines), Decision, self.steps.path)
        return {"persona": self.personas().get(agent, {}), "marks": _marks(rows, 1, self.done)}

    def all_tracks(self) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield each agent with what `track` returns for it, but read the records only once for all agents."""
        personas, marks = self.personas(), [_no_marks(1, self.done) for _ in range(self.agents)]
        for span in self._spans():
            for row in self._rows(*span):
                _mark(marks[row.agent], row, 1)
        for agent, mine in enumerate(marks):
            yield agent, {"persona": personas.get(agent, {}), "marks": mine}

    def stream(self, number: int, chunk: int) -> dict[str, Any]:
        """Return the lines of a world's own record file for a chunk of steps; the first lines if they have no step."""
        first, last = self.chunk(chunk, self.steps_per_chunk)
        rows = self._streams[number].rows(first, last) if number < len(self._streams) else []
        return {"first": first, "last": last, "rows": rows}

    def pictures(self) -> dict[str, Any]:
        """Return the steps with stored pictures, why others cannot be drawn, and whether the page needs no pictures.

        It needs none if the pictures would only show lanes. A lane is one agent's row, with a mark for each decision.
        """
        return {"kept": self.drawing.kept(), "why": self.drawing.why_not(), "lanes": self.drawing.shows_lanes()}

    def picture(self, step: int) -> Resource:
        """Return a picture of the state after a step; step 0 is the initial state."""
        return Resource(self.drawing.picture(step), PNG)

    def exports(self) -> Iterator[tuple[str, Resource]]:
        """Yield the data of an export: lanes, curves, the world's own record files, and pictures if drawing is quick.

        A part that only this form has is yielded for every agent, or for every combination of agents.
        """
        for block in range(parts_of(self.done, MARKS_PER_BLOCK)):
            yield f"lanes/{block}", Resource(_ENCODE(self.lanes(block)))
            yield f"curves/{block}", Resource(_ENCODE(self.curves(block)))
        for number, stream in enumerate(self._streams):
            chunks = parts_of(self.done, self.steps_per_chunk) if stream.by_step else 1
            for chunk in range(chunks):
                yield f"stream/{number}/{chunk}", Resource(_ENCODE(self.stream(number, chunk)))
        lanes = self.drawing.shows_lanes()
        steps, why = ([], "") if lanes else self.drawing.cheap(self.done)
        yield "pictures", Resource(_ENCODE({"kept": steps, "why": why, "lanes": lanes}))
        yield from ((f"picture/{step}", self.picture(step)) for step in steps)
        for (name, count), part in self.parts.items():
            if (name, count) not in AnyView.parts:
                for agents in itertools.product(range(self.agents), repeat=count):
                    yield "/".join(map(str, (name, *agents))), Resource(_ENCODE(part(self, *agents)))

    def _spans(self) -> Iterator[tuple[int, int]]:
        """Yield the first and the last step of every chunk."""
        for first in range(1, self.done + 1, self.steps_per_chunk):
            yield first, min(first + self.steps_per_chunk - 1, self.done)

    def _rows(self, first: int, last: int) -> list[Decision]:
        return lines_of(self.steps.read(first, last), Decision, self.steps.path)

    parts = {
        ("lanes", 1): lanes,
        ("curves", 1): curves,
        ("stream", 2): stream,
        ("pictures", 0): pictures,
        ("picture", 1): picture,
    }


def _mean(values: Sequence[float] | None) -> float | None:
    return sum(values) / len(values) if values else None


def _plain(action: Any) -> str | int | float | None:
    """Return an action for the page: a label or a number unchanged, any other value (such as a list) as JSON."""
    is_plain = action is None or (isinstance(action, str | int | float) and not isinstance(action, bool))
    return action if is_plain else msgspec.json.encode(action).decode()


def _marks(rows: Sequence[Decision], first: int, last: int) -> dict[str, list[int]]:
    marks = _no_marks(first, last)
    for row in rows:
        _mark(marks, row, first)
    return marks


def _no_marks(first: int, last: int) -> dict[str, list[int]]:
    return {name: [0] * max(0, last - first + 1) for name in _MARKS}


def _mark(marks: Mapping[str, list[int]], row: Decision, first: int) -> None:
    at = row.step - first
    marks["undecided"][at] += row.outcome in UNDECIDED
    marks["repaired"][at] += row.outcome == "repaired"
    marks["said"][at] += isinstance(row.message, str)
