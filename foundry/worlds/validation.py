"""Converts plain settings to typed settings, or raises a one-line error."""

import re
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

import msgspec

from foundry.errors import InputError, not_found

T = TypeVar("T", bound=msgspec.Struct)

_UNKNOWN = re.compile(r"Object contains unknown field `(.*)`$")
_MISSING = re.compile(r"Object missing required field `(.*)`$")


def read_settings(kind: type[T], values: object, where: str) -> T:
    """Return `values` as an object of type `kind`.

    Args:
        kind: a Struct that forbids unknown fields and contains no other such Struct.
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


def _explain(problem: str, kind: type[msgspec.Struct], where: str) -> InputError:
    keys = [field.encode_name for field in msgspec.structs.fields(kind)]
    if unknown := _UNKNOWN.match(problem):
        return not_found(f"Setting of {where}", unknown[1], keys)
    if missing := _MISSING.match(problem):
        return InputError(f"{where} lacks the setting '{missing[1]}'. It needs: {', '.join(keys)}.")
    problem, _, path = problem.partition(" - at `$")
    problem = problem.replace("`object`", "a mapping").replace("`array`", "a list")
    return InputError(f"Bad value for {where}{path.rstrip('`')}: {problem[0].lower()}{problem[1:]}.")


def refuse_repeated_names(names: Iterable[str], where: str) -> None:
    """Raise InputError if a name occurs twice."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise InputError(f"Two of {where} are named '{name}'. Give each its own name.")
        seen.add(name)


def as_list(values: Any, where: str) -> list[Any]:
    """Return a setting that is a list; raise InputError for anything else."""
    if not isinstance(values, list | tuple):
        raise InputError(f"Bad value for {where}: expected a list, got {type(values).__name__}.")
    return list(values)
