"""Where two runs part, and how far they drift from each other after that."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import msgspec

from foundry.errors import InputError, RecordError
from foundry.records import NOT_JSON, Call
from foundry.running.line_difference import CALLS, NOTHING, Difference, first_difference
from foundry.running.recorded import Place, place_of
from foundry.storing.store import RunFolder

Line = Mapping[str, Any]
"""A line of `steps.jsonl`."""


@dataclass(frozen=True)
class Drift:
    """How far two runs are apart after one step, over the agents that both have.

    Attributes:
        step: the step, from 1.
        agents: number of agents.
        elsewhere: share of agents that stand elsewhere, or look elsewhere in a 3D world.
        acted: share of agents that chose another action.
        distance: mean distance between the two places of an agent: cells in a 2D world, metres in a 3D one.
        turned: mean angle between the two headings, degrees; NaN in a 2D world.
    """

    step: int
    agents: int
    elsewhere: float
    acted: float
    distance: float
    turned: float


@dataclass(frozen=True)
class Parting:
    """What two runs do not share.

    Attributes:
        question: the first question that was put otherwise, or to one run only; `recorded` is the first run's.
        answer: the first answer that is another.
        state: the first place or action of an agent that is another.
        drift: one row a step that both runs have.
    """

    question: Difference | None
    answer: Difference | None
    state: Difference | None
    drift: tuple[Drift, ...]


def compare(one: RunFolder, other: RunFolder) -> Parting:
    """Compare two runs step by step.

    Raises:
        InputError: a run was not started, or the worlds are of different kinds.
        RecordError: a record is damaged.
    """
    steps = [_steps(run) for run in (one, other)]
    if ("pose" in steps[0][0]) != ("pose" in steps[1][0]):
        raise InputError(
            f"'{one.id}' and '{other.id}' cannot be compared: one is of a 2D world, the other of a 3D one."
        )
    calls = [_calls(run) for run in (one, other)]
    return Parting(
        question=_first(calls, _asked),
        answer=_first(calls, _answered),
        state=_first_state(*steps),
        drift=tuple(_drift(*steps)),
    )


def _steps(run: RunFolder) -> Sequence[Line]:
    content = run.steps_bytes()
    content = content[: content.rfind(b"\n") + 1]
    if not content:
        raise InputError(f"Run '{run.id}' has recorded no step yet: there is nothing to compare.")
    try:
        return msgspec.json.Decoder(dict[str, Any]).decode_lines(content)
    except NOT_JSON as error:
        raise RecordError(f"The steps of '{run.path}' cannot be read: {error}") from error


def _calls(run: RunFolder) -> dict[Place, tuple[int, Call]]:
    try:
        return {place_of(call): (number, call) for number, call in enumerate(run.calls(), start=1)}
    except NOT_JSON as error:
        raise RecordError(f"The calls of '{run.path}' cannot be read: {error}") from error


def _asked(call: Call) -> Any:
    return {"messages": call.messages}


def _answered(call: Call) -> Any:
    return {"text": call.text, "ending": call.ending}


def _first(calls: Sequence[Mapping[Place, tuple[int, Call]]], part: Callable[[Call], Any]) -> Difference | None:
    """Return the first call, in the order of the first run, whose part differs or that one run does not have."""
    one, other = calls
    for place, (number, call) in one.items():
        if place not in other:
            return Difference(CALLS, number, "", _said(part(call)), NOTHING, place)
        found = first_difference(part(call), part(other[place][1]))
        if found is not None:
            return Difference(CALLS, number, *found, place=place)
    for place, (number, call) in other.items():
        if place not in one:
            return Difference(CALLS, number, "", NOTHING, _said(part(call)), place)
    return None


def _said(part: Mapping[str, Any]) -> str:
    return str(part["text"] if "text" in part else part["messages"][-1]["content"])


def _state(line: Line) -> Mapping[str, Any]:
    """Return where an agent was, what it did and where that brought it."""
    names = (
        ("pose", "command", "pose_next") if "pose" in line else ("x", "y", "action", "direction", "x_next", "y_next")
    )
    return {name: line[name] for name in names}


def _first_state(one: Sequence[Line], other: Sequence[Line]) -> Difference | None:
    lines = {(line["step"], line["agent"]): line for line in other}
    for number, line in enumerate(one, start=1):
        place = (line["step"], line["agent"], "state")
        match = lines.get(place[:2])
        if match is None:
            return Difference("steps.jsonl", number, "", _state(line), NOTHING, place)
        found = first_difference(_state(line), _state(match))
        if found is not None:
            return Difference("steps.jsonl", number, *found, place=place)
    known = {(line["step"], line["agent"]) for line in one}
    beyond = next(
        ((n, line) for n, line in enumerate(other, start=1) if (line["step"], line["agent"]) not in known), None
    )
    if beyond is None:
        return None
    number, line = beyond
    return Difference("steps.jsonl", number, "", NOTHING, _state(line), (line["step"], line["agent"], "state"))


def _drift(one: Sequence[Line], other: Sequence[Line]) -> Iterator[Drift]:
    matches = {step: list(lines) for step, lines in _by_step(other)}
    for step, lines in _by_step(one):
        agents = {line["agent"]: line for line in matches.get(step, ())}
        pairs = [(line, agents[line["agent"]]) for line in lines if line["agent"] in agents]
        if pairs:
            yield _drift_of(step, pairs)


def _by_step(lines: Iterable[Line]) -> Iterator[tuple[int, Iterator[Line]]]:
    return groupby(lines, key=lambda line: int(line["step"]))


def _drift_of(step: int, pairs: Sequence[tuple[Line, Line]]) -> Drift:
    is_3d = "pose" in pairs[0][0]
    acted = ("command",) if is_3d else ("action", "direction")
    ends = ("pose_next",) if is_3d else ("x_next", "y_next")
    turns = [_turn(a["pose_next"]["yaw"], b["pose_next"]["yaw"]) for a, b in pairs] if is_3d else [math.nan]
    return Drift(
        step=step,
        agents=len(pairs),
        elsewhere=_mean(any(a[key] != b[key] for key in ends) for a, b in pairs),
        acted=_mean(any(a[key] != b[key] for key in acted) for a, b in pairs),
        distance=_mean(math.dist(_place(a), _place(b)) for a, b in pairs),
        turned=_mean(turns),
    )


def _place(line: Line) -> tuple[float, ...]:
    """Return where an agent stands after its step."""
    if "pose" in line:
        return tuple(line["pose_next"][axis] for axis in "xyz")
    return line["x_next"], line["y_next"]


def _turn(one: float, other: float) -> float:
    """Return the angle between two headings, degrees, 0..180."""
    return abs((one - other + 180.0) % 360.0 - 180.0)


def _mean(values: Iterable[float]) -> float:
    found = list(values)
    return math.fsum(found) / len(found)
