"""Mends broken JSON objects with the library json-repair, and rejects its guesses.

The library json-repair guesses unclear parts, so foundry compares the object that it returns with the text. If the text
has a key more often than the object, the library merged two objects, and the object is rejected. A key with quotation
marks shows that the library merged values; such an object is rejected too. A value at the end of the text may be
incomplete, so it becomes `Unfinished`.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

LONGEST = 6_000
"""Maximum number of characters of an object that is mended."""

MOST_QUOTES = 200
"""Maximum number of quotation marks, since the library may search the whole remaining text at each mark."""

MOST_BRACKETS = 16
"""Maximum number of opening brackets; each bracket is a recursive call of the library, and Python limits these."""

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
    """Stands in place of the last value of a text, since that value may be incomplete."""


KeyOf = Callable[[str], str | None]
"""Function that returns the requested key that a name means, such as "action"; None for other names."""


def mended(text: str, key_of: KeyOf) -> Mended | None:
    """Return the JSON object that a broken text means, or None if the meaning is uncertain.

    Args:
        text: the text from the opening brace of the object, to its closing brace if it has one.
        key_of: function that returns the key of a decision that a name means; the values of such keys must be certain.
    """
    if not _is_small(text):
        return None
    import json_repair  # most replies need no mending

    text = in_plain_marks(text)
    try:
        value = json_repair.loads(text, skip_json_loads=True)
    except Exception:  # noqa: BLE001 - the boundary: the library's own assertions fail at times, and then nothing is known
        return None
    if not isinstance(value, dict):
        return None
    names = list(_names(value))
    named = [(key, match.end()) for match in _KEY.finditer(text) if (key := key_of(match[1] or match[2])) is not None]
    held = Counter(key for name in names if (key := key_of(name)) is not None)
    if any(_STRANGE.search(name) for name in names) or held != Counter(key for key, _ in named):
        return None
    if named and not _is_closed(text[named[-1][1] :].lstrip()):
        value = _with_unfinished(value, named[-1][0], key_of)
    return Mended(value)


def _is_small(text: str) -> bool:
    brackets, quotes = (sum(text.count(sign) for sign in kind) for kind in ("{[(", "\"'“”"))
    return len(text) <= LONGEST and brackets <= MOST_BRACKETS and quotes <= MOST_QUOTES


def is_glued(text: str) -> bool:
    """Return whether a mended value may be wrong: it may be several values or half a value, or have unknown escapes.

    Within one value, quotation marks open before they close: `He said "go" to me`, but not `go" or "stay`.
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
    """Replace typographic quotation marks, colons and commas by the marks that JSON uses."""
    if '"' not in text:
        text = text.translate(_CURLY)
    elif _ESCAPED.match(text):
        text = text.replace('\\"', '"')
    text = _WIDE_COLON.sub(r"\1:", text)
    return _WIDE_COMMA.sub(r"\1,", text)


def _names(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        yield from value
    for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from _names(inner)


def _is_closed(rest: str) -> bool:
    """Return whether the text begins with a complete value."""
    for opening, closing in (('"', '"'), ("'", "'"), ("“", "”"), ("[", "]"), ("{", "}")):
        if rest.startswith(opening):
            return closing in rest[1:]
    return _UNQUOTED_END.search(rest) is not None


def _with_unfinished(value: Any, open_key: str, key_of: KeyOf) -> Any:
    if isinstance(value, list):
        return [_with_unfinished(item, open_key, key_of) for item in value]
    if not isinstance(value, dict):
        return value
    return {
        name: Unfinished() if key_of(name) == open_key else _with_unfinished(inner, open_key, key_of)
        for name, inner in value.items()
    }
