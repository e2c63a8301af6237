"""Mends broken JSON objects, and finds values that may be guesses.

The library mends any syntax, if necessary by guesses, so its result is compared with the text. If the text names a key
more often than the result, two objects were merged. If a key contains quotation marks, values were merged. Both results
are rejected. A value at the end of the text may be incomplete.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

LONGEST = 6_000
"""Maximum number of characters of an object that is mended."""

MOST_QUOTES = 200
"""Maximum number of quotation marks; the library may search the rest of the text from each."""

MOST_BRACKETS = 16
"""Maximum number of opening brackets; the library recurses into each, and Python's stack is finite."""

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
    """A mended object."""


@dataclass(frozen=True, slots=True)
class Unfinished:
    """Placeholder for a value that may continue after the end of the text."""


KeyOf = Callable[[str], str | None]
"""Returns the decision key that a name means, or None for other names."""


def mended(text: str, key_of: KeyOf) -> Mended | None:
    """Return the object that a text means, or None if this is uncertain.

    Args:
        text: the text from the opening brace of the object, to its closing brace if it has one.
        key_of: returns the decision key that a name means; mended values of these keys must be certain.
    """
    if not _is_small(text):
        return None
    import json_repair  # most replies need no mending

    text = in_plain_marks(text)
    try:
        found = json_repair.loads(text, skip_json_loads=True)
    except Exception:  # noqa: BLE001 - the boundary: the library's own assertions fail at times, and then nothing is known
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
    """Return whether the library mends the text in bounded time."""
    brackets, quotes = (sum(text.count(one) for one in kind) for kind in ("{[(", "\"'“”"))
    return len(text) <= LONGEST and brackets <= MOST_BRACKETS and quotes <= MOST_QUOTES


def is_glued(text: str) -> bool:
    """Return whether the text may be two texts, half a text, or escaped in a way that JSON does not know.

    Quotation marks inside a text open before they close: `He said "go" to me`, but not `go" or "stay`.
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
    """Return the text with JSON's quotation marks, colons and commas in place of typographic ones."""
    if '"' not in text:
        text = text.translate(_CURLY)
    elif _ESCAPED.match(text):
        text = text.replace('\\"', '"')
    text = _WIDE_COLON.sub(r"\1:", text)
    return _WIDE_COMMA.sub(r"\1,", text)


def _names(value: Any) -> Iterator[str]:
    """Yield the names of all keys in a tree, which has at most `MOST_BRACKETS` levels."""
    if isinstance(value, dict):
        yield from value
    for one in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from _names(one)


def _is_closed(rest: str) -> bool:
    """Return whether the first value in the text ends before the text does."""
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
