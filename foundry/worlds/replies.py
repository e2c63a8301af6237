"""Finds JSON objects in a text, even broken ones, in time linear in its length, and never raises an error."""

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

Mend = Callable[[str], dict[str, Any]]
"""Function that converts broken JSON to an object; the object is empty if its meaning is uncertain."""


class Conflicting(dict[str, Any]):
    """A JSON object that has the same key twice, with different values."""


@dataclass(frozen=True, slots=True)
class _DecodedObject:
    value: dict[str, Any]
    end: int


MAX_OBJECTS = 32
"""Maximum number of objects in a text; a text with more objects contains no clear decision."""

MAX_BRACKETS = 200
"""Maximum number of brackets in an object, which keeps nesting far below Python's recursion limit."""

MAX_TOKENS = 2000
"""Maximum number of tokens (names, values, marks) that are read of an object that is not valid JSON."""

_START = re.compile(r"\{\s*+[\"']")
_MENDABLE_START = re.compile(r"""\{\s*+(?:["'“„]|\\"|//|\#|/\*|[^\W\d][\w ]{0,39}+[:：])""")
_BRACE = re.compile(r"[{}]")
_THINK = re.compile(r"(</?(?:think|thinking|thought)>)", re.IGNORECASE)
_OPENING = ("<think>", "<thinking>", "<thought>")
_CLOSING = ("</think>", "</thinking>", "</thought>")
_TOKEN = re.compile(r""""[^"\\]*+(?:\\.[^"\\]*+)*+"|'[^'\\]*+(?:\\.[^'\\]*+)*+'|[{}\[\]:,]|[-+.\w]++|\s++""", re.DOTALL)
_ESCAPE = re.compile(r'\\.|"', re.DOTALL)
_CONSTANTS = {"True": "true", "False": "false", "None": "null"}


def merged(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """Return the pairs as a dict; if a key occurs with different values, the dict is a `Conflicting`."""
    fields = dict(pairs)
    if len(fields) == len(pairs) or all(fields[key] == value for key, value in pairs):
        return fields
    return Conflicting(fields)


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is not JSON")


_STRICT = json.JSONDecoder(object_pairs_hook=merged, parse_constant=_refuse)
_LENIENT = json.JSONDecoder(object_pairs_hook=merged, parse_constant=_refuse, strict=False)


def whole_object(text: str) -> dict[str, Any] | None:
    """Return the JSON object of a text that contains nothing else but blanks; None for any other text."""
    text = text.strip()
    if not text.startswith("{"):
        return None
    decoded = _decode(_STRICT, text, 0)
    return decoded.value if decoded is not None and decoded.end == len(text) else None


def find_objects(text: str, mend: Mend | None = None) -> list[dict[str, Any]]:
    """Return the outermost JSON objects in the text, in order; an empty list if there are too many (`MAX_OBJECTS`).

    Args:
        text: the text to search.
        mend: function that converts an object that is not valid JSON, from its first brace to its last.
    """
    objects: list[dict[str, Any]] = []
    position: int | None = 0
    starts = _START if mend is None else _MENDABLE_START
    for _ in range(MAX_OBJECTS):
        start = starts.search(text, position) if position is not None else None
        if start is None:
            return objects
        decoded = _decode(_LENIENT, text, start.start()) or _decode_loosely(text, start.start())
        if decoded is not None:
            objects.append(decoded.value)
            position = decoded.end
            continue
        position = _end_of_braces(text, start.start())
        if mend is not None:
            objects.append(mend(text[start.start() : position]))
    return []


def without_thinking(text: str) -> str:
    """Return the text without thinking between tags such as `<think>`, even if one of the two tags is missing."""
    outside: list[str] = []
    thinking = False
    for part in _THINK.split(text):
        tag = part.lower()
        if tag in _OPENING:
            thinking = True
        elif tag in _CLOSING:
            if not thinking:  # the opening tag was part of the prompt
                outside.clear()
            thinking = False
        elif not thinking:
            outside.append(part)
    return "".join(outside)


def _decode(decoder: json.JSONDecoder, text: str, start: int) -> _DecodedObject | None:
    try:
        value, end = decoder.raw_decode(text, start)
    except (ValueError, RecursionError):
        return None
    if not isinstance(value, dict) or text.count("{", start, end) + text.count("[", start, end) > MAX_BRACKETS:
        return None
    return _DecodedObject(value, end)


def _decode_loosely(text: str, start: int) -> _DecodedObject | None:
    parts: list[str] = []
    depth, position = 0, start
    for _ in range(MAX_TOKENS):
        match = _TOKEN.match(text, position)
        if match is None:
            return None
        token, position = match[0], match.end()
        if token.isspace():
            continue
        if token in ("{", "["):
            depth += 1
        elif token in ("}", "]"):
            depth -= 1
            if parts[-1] == ",":
                parts.pop()
        parts.append(_as_json(token))
        if depth == 0:
            decoded = _decode(_LENIENT, " ".join(parts), 0)
            return None if decoded is None else _DecodedObject(decoded.value, position)
    return None


def _as_json(token: str) -> str:
    if token[0] != "'":
        return _CONSTANTS.get(token, token)
    return '"' + _ESCAPE.sub(lambda match: {'"': '\\"', "\\'": "'"}.get(match[0], match[0]), token[1:-1]) + '"'


def _end_of_braces(text: str, start: int) -> int | None:
    """Return the index after the brace that closes the brace at `start`, or None if it is never closed.

    The search for objects continues there, because objects inside an unreadable object are no decisions.
    """
    depth = 0
    for brace in _BRACE.finditer(text, start):
        depth += 1 if brace[0] == "{" else -1
        if depth == 0:
            return brace.end()
    return None
