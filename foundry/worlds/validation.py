"""Converts settings from YAML to typed objects, or raises an error of one line."""

import math
import re
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar, get_args

import msgspec

from foundry.errors import InputError, not_found

T = TypeVar("T", bound=msgspec.Struct)

_UNKNOWN = re.compile(r"Object contains unknown field `(.*)`$")
_MISSING = re.compile(r"Object missing required field `(.*)`$")


def read_settings(kind: type[T], values: object, where: str) -> T:
    """Convert plain settings to an object of the given class.

    Args:
        kind: a Struct that forbids unknown fields.
        values: plain containers from YAML.
        where: key of the settings, for the message.

    Raises:
        InputError: a key is unknown or missing, or a value has the wrong type or is out of range.
    """
    if isinstance(values, Mapping):
        values = dict(values)
    try:
        return msgspec.convert(values, kind)
    except msgspec.ValidationError as error:
        raise _explain(str(error), kind, where) from error


def _explain(message: str, kind: type[msgspec.Struct], where: str) -> InputError:
    problem, _, place = message.partition(" - at `$")
    place = f"{where}{place.rstrip('`')}"
    keys = [field.encode_name for field in msgspec.structs.fields(_struct_at(kind, place.removeprefix(where)))]
    if unknown := _UNKNOWN.match(problem):
        return not_found(f"Setting of {place}", unknown[1], keys)
    if missing := _MISSING.match(problem):
        return InputError(f"{place} lacks the setting '{missing[1]}'. It needs: {', '.join(keys)}.")
    for name, plain in (("object", "a mapping"), ("array", "a list")):
        problem = problem.replace(f"`{name}`", plain).replace(f"`{name} | null`", f"{plain} or null")
    return InputError(f"Bad value for {place}: {problem[0].lower()}{problem[1:]}.")


def _struct_at(kind: type[msgspec.Struct], path: str) -> type[msgspec.Struct]:
    """Return the class of the settings that contain the last key of a path such as `.places[0].center`."""
    for name in re.findall(r"\w[^.\[]*", path):
        declared = next((field.type for field in msgspec.structs.fields(kind) if field.encode_name == name), None)
        parts = (declared, *get_args(declared))
        kind = next((part for part in parts if isinstance(part, type) and issubclass(part, msgspec.Struct)), kind)
    return kind


def refuse_repeated_names(names: Iterable[str], where: str) -> None:
    """Raise InputError if a name occurs twice in a list of settings, such as the places of a world."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise InputError(f"{where} contains the name '{name}' twice. Give each entry its own name.")
        seen.add(name)


def check_number(
    key: str, value: Any, least: float = -math.inf, most: float = math.inf, *, whole: bool = False
) -> None:
    """Raise InputError unless a setting is a finite number within bounds; with `whole`, it must be an integer."""
    is_number = isinstance(value, int if whole else int | float) and not isinstance(value, bool)
    if is_number and least <= value <= most and abs(value) < math.inf:
        return
    bounds = [f"{word} {bound}" for word, bound in (("from", least), ("to", most)) if math.isfinite(bound)]
    raise InputError(" ".join([f"{key} must be a {'whole ' * whole}number", *bounds]) + f"; got {value!r}.")


def check_flag(key: str, value: object) -> None:
    """Raise InputError unless a setting is true or false."""
    if not isinstance(value, bool):
        raise InputError(f"{key} must be true or false; got {value!r}.")


def as_list(values: Any, where: str) -> list[Any]:
    """Return a setting that is a list; raise InputError for anything else."""
    if not isinstance(values, list | tuple):
        raise InputError(f"Bad value for {where}: expected a list, got {type(values).__name__}.")
    return list(values)
