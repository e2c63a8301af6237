"""Normalises texts, and builds patterns of whole words, for rules that search texts."""

import re
import unicodedata

LETTERS = "a-z\u00df-\u024f\u0370-\u03ff\u0400-\u04ff"
"""Letters that may not stand directly before or after a whole word.

LETTERS contains no letters of scripts that write no blanks between words, such as Japanese.
"""

_STRUCTURE = re.compile(r"\\.|\[(?:\\.|[^\]])*\]|[()|]")
"""Finds the brackets and bars that structure a pattern; escapes and sets of characters are skipped."""


def plain(text: str) -> str:
    """Return the text in lower case, with full-width and composed characters normalised."""
    return unicodedata.normalize("NFKC", text).lower()


def whole_words(pattern: str) -> str:
    """Return a pattern that matches only whole words."""
    return f"(?<![{LETTERS}])(?:{pattern})(?![{LETTERS}])"


def indexed(pattern: str) -> str:
    """Return a faster pattern: alternatives that begin with the same letter are grouped, all other ones come last."""
    groups: dict[str, list[str]] = {}
    for alternative in alternatives(pattern):
        plain_start = alternative[:1].isalpha() and alternative[1:2] not in ("?", "*", "{", "+")
        groups.setdefault(alternative[0] if plain_start else "", []).append(alternative)
    last = groups.pop("", [])
    indexed_groups = [f"{first}(?:{'|'.join(text[1:] for text in group)})" for first, group in groups.items()]
    return "|".join([*indexed_groups, *last])


def alternatives(pattern: str) -> list[str]:
    """Return the outermost alternatives of a pattern."""
    parts, depth, start = [], 0, 0
    for match in _STRUCTURE.finditer(pattern):
        if match[0] == "|" and not depth:
            parts.append(pattern[start : match.start()])
            start = match.end()
        depth += {"(": 1, ")": -1}.get(match[0], 0)
    return [*parts, pattern[start:]]
