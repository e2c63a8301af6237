"""Finds and replaces parts of JSON values, at any depth."""

import copy
from collections.abc import Collection, Iterator
from typing import Any


def places(value: Any, path: tuple[Any, ...] = (), *, skip: Collection[str] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every part; keys to skip are left out with all that they hold."""
    yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, part in inner:
        if key not in skip:
            yield from places(part, (*path, key), skip=skip)


def put(value: Any, path: tuple[Any, ...], new: Any) -> Any:
    if not path:
        return new
    copied = copy.copy(value)
    copied[path[0]] = put(value[path[0]], path[1:], new)
    return copied
