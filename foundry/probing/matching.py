"""Decisions of a run with the calls that they come from, by step, agent and kind of question."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from typing import TypeAlias, TypeVar

from foundry.records import Call

T = TypeVar("T")
Place: TypeAlias = tuple[int, int, str | None]
"""Step, agent and kind of question; what is asked there again is in its order."""


def with_calls(lines: Iterable[tuple[Place, T]], calls: Iterable[Call]) -> Iterator[tuple[T, Call | None]]:
    """Yield lines of decisions with their calls, in the order of the calls, lines without any behind.

    Where a place has not as many lines as calls, nobody knows which is which, and its lines have none.

    Args:
        lines: each behind its place.
        calls: of the same run.
    """
    decided = _by_place(lines)
    called = _by_place(((call.step, call.agent, call.kind), call) for call in calls)
    for place in dict.fromkeys((*called, *decided)):
        mine, asked = decided.get(place, []), called.get(place, [])
        yield from zip(mine, asked if len(asked) == len(mine) else itertools.repeat(None), strict=False)


def _by_place(found: Iterable[tuple[Place, T]]) -> dict[Place, list[T]]:
    places: dict[Place, list[T]] = {}
    for place, one in found:
        places.setdefault(place, []).append(one)
    return places
