"""Mends what was meant as one JSON object and is none, and tells which of its values are in doubt.

The library mends any syntax, and where it must guess it guesses. So what it returns is held against the text: an
object that names a key more often in the text than in what came out was put together from two, a key with quotation
marks in it was put together from values, and a value that the text ends within may have gone on.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

LONGEST = 6_000
"""Characters of an object that is mended."""

MOST_QUOTES = 200
"""Quotation marks in it; the library may look through the rest of the text from each."""

MOST_BRACKETS = 16
"""Opening brackets in it; the library goes down into each, and Python's stack is finite."""

_CURLY = str.maketrans("“”„‟＂", '"""""')
_KEY = re.compile(
    r"""["'“”]\s*+([^"'“”\\:：{}\[\],\n]{1,40}+)["'“”]\s*+[:：]|(?<=[{,\n])[ \t]{0,40}+([^\W\d][\w ]{0,39}+)[:：]"""
)
_WIDE_COLON = re.compile(r'(["”])\s*+：')
_WIDE_COMMA = re.compile(r'(["”])\s*+[，、](?=\s*+["“])')
_ESCAPED = re.compile(r'\{\s*+\\"')
_STRANGE = re.compile(r"[\"“”{}\[\]\n:]")
_UNQUOTED_END = re.compile(r"[,}\n\]]")


class Mended(dict[str, Any]):
    """An object that was mended."""


@dataclass(frozen=True, slots=True)
class Unfinished:
    """Stands for a value that the text may end within."""


KeyOf = Callable[[str], str | None]
"""What key a name means, or None when it is none of those to watch."""


def mended(text: str, key_of: KeyOf) -> Mended | None:
    """Return the object that a text from its opening brace on was meant as; None when that is in doubt.

    Args:
        text: the object, to its closing brace if it has one.
        key_of: the keys that must not be mistaken.
    """
    if not _is_small(text):
        return None
    import json_repair  # most replies need no mending

    text = in_plain_marks(text)
    try:
        found = json_repair.loads(text, skip_json_loads=True)
    except Exception:  # noqa: BLE001 - the boundary: it falls over its own assertions at times, and then knows nothing
        return None
    if not isinstance(found, dict):
        return None
    names = list(_names(found))
    named = [(key, match.end()) for match in _KEY.finditer(text) if (key := key_of(match[1] or match[2])) is not None]
    held = Counter(key for name in names if (key := key_of(name)) is not None)
    if any(_STRANGE.search(name) for name in names) or held != Counter(key for key, _ in named):
        return None
    if named and not _is_closed(text[named[-1][1] :].lstrip()):
        found = _with_unfinished(found, named[-1][0], key_of)
    return Mended(found)


def _is_small(text: str) -> bool:
    """Tell whether the library is done with a text in time, whatever is in it."""
    brackets, quotes = (sum(text.count(one) for one in kind) for kind in ("{[(", "\"'“”"))
    return len(text) <= LONGEST and brackets <= MOST_BRACKETS and quotes <= MOST_QUOTES


def is_glued(text: str) -> bool:
    """Tell whether a mended text may be two that stood beside each other, half of one, or escaped in no way of JSON's.

    Quotation marks within a text open before they close: `He said "go" to me`, but not `go" or "stay`.
    """
    first = text.find('"')
    if first < 0:
        return "\\" in text
    after = text[first + 1 : first + 2]
    return (
        "\\" in text
        or text.count('"') % 2 == 1
        or (first > 0 and not text[first - 1].isspace() and not after.isalnum())
    )


def in_plain_marks(text: str) -> str:
    """Return the text with the quotation marks, colons and commas of JSON where it has other ones in their place."""
    if '"' not in text:
        text = text.translate(_CURLY)
    elif _ESCAPED.match(text):
        text = text.replace('\\"', '"')
    text = _WIDE_COLON.sub(r"\1:", text)
    return _WIDE_COMMA.sub(r"\1,", text)


def _names(value: Any) -> Iterator[str]:
    """Yield the names of all keys in a tree; it is no deeper than `MOST_BRACKETS`."""
    if isinstance(value, dict):
        yield from value
    for one in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from _names(one)


def _is_closed(rest: str) -> bool:
    """Tell whether the value that a text begins with ends before the text does."""
    for opening, closing in (('"', '"'), ("'", "'"), ("“", "”"), ("[", "]"), ("{", "}")):
        if rest.startswith(opening):
            return closing in rest[1:]
    return _UNQUOTED_END.search(rest) is not None


def _with_unfinished(value: Any, open_key: str, key_of: KeyOf) -> Any:
    if isinstance(value, list):
        return [_with_unfinished(one, open_key, key_of) for one in value]
    if not isinstance(value, dict):
        return value
    return {
        name: Unfinished() if key_of(name) == open_key else _with_unfinished(one, open_key, key_of)
        for name, one in value.items()
    }
