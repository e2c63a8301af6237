"""What rules over texts share: one form of the text, and the borders of words."""

from __future__ import annotations

import unicodedata

LETTERS = "a-z\u00df-\u024f\u0370-\u03ff\u0400-\u04ff"
"""Characters that make up words, for word borders; not the scripts that are written without blanks."""


def plain(text: str) -> str:
    """Return the text in lower case and in one form as to width and composition."""
    return unicodedata.normalize("NFKC", text).lower()


def whole_words(pattern: str) -> str:
    """Return the pattern of words, held to whole words."""
    return f"(?<![{LETTERS}])(?:{pattern})(?![{LETTERS}])"


def compiled(spaced: dict[str, str], unspaced: dict[str, str]) -> str:
    """Return one pattern of tables by language: whole words, and words of scripts without blanks anywhere."""
    return "|".join([*unspaced.values(), whole_words("|".join(spaced.values()))])
