"""Edits that set one number in an observation, and change nothing else.

A quantity is a path of keys and list indices in the observation, such as `evenings.-1.went`. `evenings.count` is the
length of the list `evenings`. If other numbers of an observation depend on a quantity, the file with the form's edits
has a function in `MOVES` that sets all of these numbers.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, TypeAlias

from foundry.errors import InputError, not_found
from foundry.naming import in_room
from foundry.worlds.base import Question

Observation: TypeAlias = Mapping[str, Any]
Move: TypeAlias = Callable[[Observation, Sequence[str], float], Observation | None]
"""Function that sets the quantity at a path of an observation; it returns None if the quantity cannot have the
value.
"""
COUNT = "count"
MOST = 100
"""Maximum number of values that the setting `sweep_over` may list."""
_EXAMPLE = "sweep_over=fires.0.distance=1..20, or =1,2,5"
_ITEM = re.compile(r"(?P<first>-?\d+(?:\.\d+)?)(?:\.\.(?P<last>-?\d+))?")


def moves_of(text: str) -> list[str]:
    """Return the name of one edit per value in a text such as `fires.0.distance=1..20`."""
    path, _, values = text.partition("=")
    numbers = [value for item in values.strip("[]").split(",") for value in _values(item.strip(), text)]
    if not path or len(numbers) > MOST:
        raise InputError(f"sweep_over={text} must name a quantity and at most {MOST} values. Write {_EXAMPLE}.")
    return [f"{path}={value:g}" for value in dict.fromkeys(numbers)]


def _values(item: str, text: str) -> list[float]:
    match = _ITEM.fullmatch(item)
    if match is None or (match["last"] is not None and "." in match["first"]):
        raise InputError(f"sweep_over={text} names no numbers as values. Write {_EXAMPLE}.")
    if match["last"] is None:
        return [float(match["first"])]
    values = range(int(match["first"]), int(match["last"]) + 1)
    if not values:
        raise InputError(f"sweep_over={text} runs backwards. Write the smaller value first.")
    return [float(value) for value in values[: MOST + 1]]


def split(name: str) -> tuple[str, float]:
    """Split the name of an edit, such as `fires.0.distance=3`, into the path of the quantity and its value."""
    path, _, value = name.rpartition("=")
    return path, float(value)


def moved(question: Question, path: str, value: float, form: str) -> Question | None:
    """Return the question with a quantity set to a value; None if the quantity cannot have this value here."""
    keys = path.split(".")
    move = next((mover for pattern, mover in _moves(form).items() if re.fullmatch(pattern, path)), _set)
    changed = move(question.observation, keys, value)
    return None if changed is None else replace(question, observation=dict(changed))


def check_path(path: str, form: str, questions: Iterable[Question], values: Sequence[float]) -> None:
    """Raise InputError if every value of the list is impossible for the quantity in every question."""
    known: dict[str, None] = {}
    for question in questions:
        if any(moved(question, path, value, form) is not None for value in values):
            return
        known.update(dict.fromkeys(quantities(question.observation)))
    if path in known:
        raise InputError(f"No moment allows any of these values for {path}. Choose other values, as in {_EXAMPLE}.")
    raise not_found("Quantity", path, known, "A quantity is a number in the observation of an agent.")


def quantities(value: Any, path: str = "") -> Iterator[str]:
    """Yield the paths of all numbers in an observation; from a list, take only the first and the last entry."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from quantities(inner, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list):
        yield f"{path}.{COUNT}"
        for place in (0, -1) if len(value) > 1 else range(len(value)):
            yield from quantities(value[place], f"{path}.{place}")
    elif _is_number(value):
        yield path


@cache
def _moves(form: str) -> Mapping[str, Move]:
    return in_room(f"foundry.worlds.{form}.{form}_edits", "MOVES") or {}


def _set(inside: Any, keys: Sequence[str], value: float) -> Any:
    key, rest = keys[0], keys[1:]
    if isinstance(inside, list):
        if key == COUNT and not rest:
            return inside[: int(value)] if value == int(value) and 0 <= value <= len(inside) else None
        place = int(key) if re.fullmatch(r"-?\d+", key) else len(inside)
        if not -len(inside) <= place < len(inside):
            return None
        changed = _changed(inside[place], rest, value)
        return (
            None if changed is None else [*inside[: place % len(inside)], changed, *inside[place % len(inside) + 1 :]]
        )
    if not isinstance(inside, Mapping) or key not in inside:
        return None
    changed = _changed(inside[key], rest, value)
    return None if changed is None else {**inside, key: changed}


def _changed(inner: Any, rest: Sequence[str], value: float) -> Any:
    if rest:
        return _set(inner, rest, value)
    if not _is_number(inner):
        return None
    return int(value) if isinstance(inner, int) and value == int(value) else value


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
