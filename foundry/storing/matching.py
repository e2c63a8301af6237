"""Matches the records of a run to its calls.

A call is identified by its step, its agent, the kind of its question, and the number of earlier calls with the same
three values.
"""

import itertools
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import TypeAlias, TypeVar

from foundry.records import Call
from foundry.worlds.base import QuestionKey

T = TypeVar("T")
Numbered: TypeAlias = tuple[QuestionKey, int]
"""A question, and the number of times that it was asked before."""


def place_of(call: Call) -> QuestionKey:
    """Return the question of a call: step, agent and kind."""
    return call.step, call.agent, call.kind


def numbered(items: Iterable[T], place: Callable[[T], QuestionKey]) -> Iterator[tuple[Numbered, T]]:
    """Yield the items of a run, each with its question and with the number of earlier items of this question."""
    counts: Counter[QuestionKey] = Counter()
    for item in items:
        here = place(item)
        yield (here, counts[here]), item
        counts[here] += 1


def with_calls(lines: Iterable[tuple[QuestionKey, T]], calls: Iterable[Call]) -> Iterator[tuple[T, Call | None]]:
    """Yield each line with a decision and its call, in the order of the calls; lines without a call come last.

    If a question has more lines than calls, or fewer, the match is unknown, and its lines get no call.
    """
    decided = _by_place(lines)
    called = _by_place((place_of(call), call) for call in calls)
    for place in dict.fromkeys((*called, *decided)):
        mine, asked = decided.get(place, []), called.get(place, [])
        yield from zip(mine, asked if len(asked) == len(mine) else itertools.repeat(None), strict=False)


def _by_place(items: Iterable[tuple[QuestionKey, T]]) -> dict[QuestionKey, list[T]]:
    places: dict[QuestionKey, list[T]] = {}
    for place, item in items:
        places.setdefault(place, []).append(item)
    return places
