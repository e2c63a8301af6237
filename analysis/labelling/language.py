"""Whether a text is in a language that the rule of warnings reads.

By its script, where most of its letters are of none that those languages are written in. Otherwise, for Latin and
Cyrillic letters, by `py3langid`: shares of 140 languages after the sequences of characters, the same for the same
text. Short texts, names and numbers give it no evidence, so they count as read; so does what is no language at all.
"""

from __future__ import annotations

import re
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from py3langid.langid import LanguageIdentifier

READ = frozenset(("en", "ja", "de", "fr", "es", "zh", "pt", "it", "ru", "ko", "pl", "nl", "pcm"))
"""Codes of the languages that are read; `pcm`, Nigerian Pidgin, is what broken English looks like."""

IDENTIFIED_BY = f"py3langid {version('py3langid')}"
"""Whose shares decide; another version may find others."""

_NO_LANGUAGE = "zxx"

_SURE, _UNLIKELY, _TOGETHER = 0.6, 0.1, 3
"""A text is not read if the likeliest languages that are not, so many, have this share together, and those that are
read less than that."""

_SEEN_LENGTH = 400
"""Letters that are looked at."""

_LETTERS = re.compile(r"[^\W\d_]")
_READ_SCRIPTS = re.compile(
    "[a-z\u00aa-\u024f\u1e00-\u1eff\u0400-\u052f\u1100-\u11ff\u2e80-\u9fff\ua960-\ua97f\uac00-\ud7ff\uf900-\ufaff"
    "\U00020000-\U0003ffff]"
)
_ALPHABETS = re.compile("[a-z\u00aa-\u024f\u1e00-\u1eff\u0400-\u052f]")
_NAMES = re.compile(r"(?<!\w)[^\W\d_]*[\d_]\w*")


def is_read(text: str) -> bool:
    """Return whether a text, in lower case, is in a language that is read, or says too little to tell."""
    seen = _NAMES.sub(" ", text[: 4 * _SEEN_LENGTH])[:_SEEN_LENGTH]
    letters, of_read, of_alphabets = (len(kind.findall(seen)) for kind in (_LETTERS, _READ_SCRIPTS, _ALPHABETS))
    if 2 * of_read < letters:
        return False
    return 2 * of_alphabets < letters or not letters or not _is_another(seen)


def _is_another(text: str) -> bool:
    ranked: list[tuple[str, float]] = [
        (code, share) for code, share in _identifier().rank(text) if code != _NO_LANGUAGE
    ]
    others = [share for code, share in ranked if code not in READ]
    read = sum(share for code, share in ranked if code in READ)
    return read < _UNLIKELY and sum(others[:_TOGETHER]) >= _SURE


@cache
def _identifier() -> LanguageIdentifier:
    from py3langid.langid import MODEL_FILE, LanguageIdentifier

    return LanguageIdentifier.from_model_file(MODEL_FILE, norm_probs=True)
