"""YAML of unknown origin: only plain values, and nothing that grows or nests without bound."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import yaml

from foundry.errors import RecordError

LARGEST = 256 * 1024 * 1024
"""Bytes of text."""
DEEPEST = 100
"""Levels of nesting; the parser would fail at some tens of thousands, and take the process with it."""
MOST_VALUES = 20_000_000
"""Values after all aliases are expanded."""
MOST_SETTINGS = 100_000
"""The same in a configuration file, all of which is built as objects."""

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_RUN_LINE = re.compile(r'^- \{"id":"[\w-]+","condition":\d+,"seed":\d+\}$', re.MULTILINE)
"""A run of a sweep, which opens and closes what it opens; there may be very many of them."""


def read_config(file: Path) -> Any:
    """Return the content of a configuration file.

    Raises:
        RecordError: it is no YAML of plain values, or grows or nests without bound.
    """
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
    return load_plain(text, file, most=MOST_SETTINGS)


def load_plain(text: str, where: object, *, most: int = MOST_VALUES) -> Any:
    """Return the value of a YAML text.

    Args:
        text: the text.
        where: what an error calls it.
        most: values that it may have.

    Raises:
        RecordError: it is no YAML of plain values, or too large, too deep, or too much once aliases are expanded.
    """
    if len(text) > LARGEST:
        raise RecordError(f"{where} is refused: it has {len(text):,} characters, more than {LARGEST:,}.")
    if _depth(_RUN_LINE.sub("", text), where) > DEEPEST:
        raise RecordError(f"{where} is refused: it nests deeper than {DEEPEST} levels.")
    try:
        value = yaml.load(text, Loader=_Loader)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise RecordError(f"{where} cannot be read: {type(error).__name__}: {' '.join(str(error).split())}") from error
    _check_expanded(value, where, most)
    return value


def _depth(text: str, where: object) -> int:
    """Return how deep the text nests, and stop counting beyond what is allowed."""
    depth = deepest = 0
    try:
        for event in yaml.parse(text, Loader=_Loader):
            if isinstance(event, yaml.CollectionStartEvent):
                depth += 1
                deepest = max(deepest, depth)
                if deepest > DEEPEST:
                    break
            elif isinstance(event, yaml.CollectionEndEvent):
                depth -= 1
    except yaml.YAMLError as error:
        raise RecordError(f"{where} cannot be read: {' '.join(str(error).split())}") from error
    return deepest


def _check_expanded(value: Any, where: object, most: int) -> None:
    """Count the values with every alias expanded, each shared part once."""
    counts: dict[int, int] = {}
    open_parts: set[int] = set()

    def count(part: Any) -> int:
        if not isinstance(part, dict | list):
            return 1
        if id(part) in open_parts:
            raise RecordError(f"{where} is refused: a part of it holds itself.")
        if id(part) not in counts:
            open_parts.add(id(part))
            inner = part.values() if isinstance(part, dict) else part
            counts[id(part)] = 1 + sum(map(count, inner))
            open_parts.remove(id(part))
        return counts[id(part)]

    if count(value) > most:
        raise RecordError(f"{where} is refused: with its aliases expanded it has more than {most:,} values.")
