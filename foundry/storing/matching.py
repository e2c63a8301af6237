"""Matches records of a run to calls, by step, agent, kind of question, and the number of earlier equal questions."""

import itertools
from collections.abc import Callable, Iterable, Iterator
from typing import TypeAlias, TypeVar

from foundry.records import Call
from foundry.worlds.base import Asked

T = TypeVar("T")
Numbered: TypeAlias = tuple[Asked, int]
"""A question, and how often it was asked before."""


def place_of(call: Call) -> Asked:
    """Return the question of a call."""
    return call.step, call.agent, call.kind


def numbered(items: Iterable[T], place: Callable[[T], Asked]) -> Iterator[tuple[Numbered, T]]:
    """Yield items of a run in order, each with its question and number."""
    counts: dict[Asked, int] = {}
    for item in items:
        here = place(item)
        before = counts.get(here, 0)
        counts[here] = before + 1
        yield (here, before), item


def with_calls(lines: Iterable[tuple[Asked, T]], calls: Iterable[Call]) -> Iterator[tuple[T, Call | None]]:
    """Yield lines of decisions with their calls, in the order of the calls; lines without a call come last.

    If a question's numbers of lines and of calls differ, the match is unknown, and its lines have no call.
    """
    decided = _by_place(lines)
    called = _by_place((place_of(call), call) for call in calls)
    for place in dict.fromkeys((*called, *decided)):
        mine, asked = decided.get(place, []), called.get(place, [])
        yield from zip(mine, asked if len(asked) == len(mine) else itertools.repeat(None), strict=False)


def _by_place(items: Iterable[tuple[Asked, T]]) -> dict[Asked, list[T]]:
    places: dict[Asked, list[T]] = {}
    for place, item in items:
        places.setdefault(place, []).append(item)
    return places
