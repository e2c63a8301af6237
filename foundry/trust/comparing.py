"""Finds the first difference of two runs, and measures how far they are apart at each later step."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from foundry.errors import InputError, RecordError
from foundry.records import Call
from foundry.running.recorded import CALLS, NOTHING, Difference, first_difference
from foundry.storing.matching import Numbered, numbered, place_of
from foundry.storing.run_files import lines_of, whole_lines
from foundry.storing.store import RunFolder
from foundry.worlds.base import QuestionKey
from foundry.worlds.compared import Compared, Line, compared_of

STEPS = "steps.jsonl"
T = TypeVar("T")


@dataclass(frozen=True)
class Drift:
    """The distance of two runs after a step, averaged over the decisions that both runs have.

    Attributes:
        step: the step, from 1.
        decisions: number of decisions; an agent may decide several times in a step.
        acted: share of decisions that differ.
        elsewhere: share of decisions after which the agent is at another place or view; NaN without places.
        distance: mean distance between an agent's places, cells in a 2D world, metres in a 3D world; else NaN.
        turned: mean angle between an agent's headings, degrees; NaN without headings.
        utility: mean difference between an agent's utilities; NaN without utilities.
    """

    step: int
    agents: int
    decisions: int
    acted: float
    elsewhere: float
    distance: float
    turned: float
    utility: float


@dataclass(frozen=True)
class Parting:
    """The first differences of two runs; in each difference, `recorded` is the value of the first given run.

    Attributes:
        question: the first question that differs, or that only one run has.
        drift: a row for each step that both runs have.
    """

    question: Difference | None
    answer: Difference | None
    state: Difference | None
    drift: tuple[Drift, ...]


def compare(first: RunFolder, other: RunFolder) -> Parting:
    """Compare two runs, whose worlds have the same form, step by step."""
    forms = [run.declared.form for run in (first, other)]
    if forms[0] != forms[1]:
        raise InputError(
            f"Cannot compare '{first.id}' and '{other.id}': their forms are '{forms[0]}' and '{forms[1]}'."
        )
    steps = [_steps(run) for run in (first, other)]
    calls = [_numbered(run.calls(), place_of) for run in (first, other)]
    compared = compared_of(forms[0])
    try:
        return Parting(
            question=_first_call(calls, lambda call: {"messages": call.messages}),
            answer=_first_call(calls, lambda call: {"text": call.text, "ending": call.ending}),
            state=_first(steps, lambda line: compared.state_of(line, first.declared), STEPS),
            drift=tuple(_drift(steps[0], steps[1], compared)),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise RecordError(
            f"The steps of '{first.id}' or '{other.id}' do not have the form '{forms[0]}', which their sweep declares "
            f"({type(error).__name__}: {error})."
        ) from error


def _steps(run: RunFolder) -> dict[Numbered, tuple[int, Line]]:
    content = whole_lines(run.steps_bytes())
    if not content:
        raise InputError(f"Run '{run.id}' has no recorded step yet, so it cannot be compared.")
    try:
        return _numbered(lines_of(content, dict[str, Any], run.stream_path("steps")), _decision_of)
    except (KeyError, TypeError) as error:
        raise RecordError(f"The steps of '{run.path}' cannot be compared: {type(error).__name__} {error}.") from error


def _decision_of(line: Line) -> QuestionKey:
    return line["step"], line["agent"], line.get("kind", "state")


def _numbered(lines: Iterable[T], place: Callable[[T], QuestionKey]) -> dict[Numbered, tuple[int, T]]:
    """Return the numbered lines (from 1) of a file, by question and how often this question occurred before."""
    by_call = numbered(lines, place)
    return {asked: (number, line) for number, (asked, line) in enumerate(by_call, start=1)}


def _first_call(calls: Sequence[Mapping[Numbered, tuple[int, Call]]], part: Callable[[Call], Any]) -> Difference | None:
    return _first(calls, part, CALLS, _text_of)


def _text_of(part: Mapping[str, Any]) -> str:
    return str(part["text"] if "text" in part else part["messages"][-1]["content"])


def _first(
    lines: Sequence[Mapping[Numbered, tuple[int, T]]],
    part: Callable[[T], Any],
    file: str,
    shown: Callable[[Any], Any] = lambda value: value,
) -> Difference | None:
    """Return the first line that only one run has, or whose `part` differs."""
    first, other = lines
    for key, (number, line) in first.items():
        if key not in other:
            return Difference(file, number, "", shown(part(line)), NOTHING, key[0])
        difference = first_difference(part(line), part(other[key][1]))
        if difference is not None:
            return Difference(file, number, *difference, place=key[0])
    for key, (number, line) in other.items():
        if key not in first:
            return Difference(file, number, "", NOTHING, shown(part(line)), key[0])
    return None


def _drift(
    first: Mapping[Numbered, tuple[int, Line]], other: Mapping[Numbered, tuple[int, Line]], compared: Compared
) -> Iterator[Drift]:
    pairs: dict[int, list[tuple[Line, Line]]] = {}
    for key, (_, line) in first.items():
        if key in other:
            pairs.setdefault(int(line["step"]), []).append((line, other[key][1]))
    for step, both in pairs.items():
        yield _drift_of(step, both, compared)


def _drift_of(step: int, pairs: Sequence[tuple[Line, Line]], compared: Compared) -> Drift:
    place, heading = compared.place, compared.heading
    distances = [] if place is None else [math.dist(place(a), place(b)) for a, b in pairs]
    turns = [] if heading is None else [_turn(heading(a), heading(b)) for a, b in pairs]
    utilities = [(a.get("utility"), b.get("utility")) for a, b in pairs]
    return Drift(
        step=step,
        agents=len({a["agent"] for a, _ in pairs}),
        decisions=len(pairs),
        acted=_mean(not compared.acts_alike(a, b) for a, b in pairs),
        elsewhere=_mean(any(a[key] != b[key] for key in compared.ends) for a, b in pairs if compared.ends),
        distance=_mean(distances),
        turned=_mean(turns),
        utility=_mean(abs(a - b) for a, b in utilities if a is not None and b is not None),
    )


def _turn(first: float, other: float) -> float:
    """Return the angle between two headings, degrees, 0..180."""
    return abs((first - other + 180.0) % 360.0 - 180.0)


def _mean(values: Iterable[float]) -> float:
    numbers = list(values)
    return math.fsum(numbers) / len(numbers) if numbers else math.nan
