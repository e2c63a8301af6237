"""When a message is a warning: a rule over its words, the same for every model.

A text is a warning when it mentions a configured fire by its name, or a word for fire, flames, smoke, burning
or evacuation in one of the languages below. The rule sees words, not meaning: "no fire here" and "has the
fire gone out?" count, "danger!" alone does not. Case, width (full-width letters) and Unicode composition make
no difference. Words of alphabets with blanks between words match whole words; Chinese, Japanese and Korean
ones match anywhere, as those texts have no blanks to go by (`fire1` is found in both kinds of text).
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache

from analysis.words import LETTERS, compiled, plain

RULE_VERSION = 1
"""Raised whenever a text could be labelled otherwise than before."""

_IN_NAMES = LETTERS + "0-9_"
"""Characters that make up names: `fire1` is not found in `fire12`, though the word `fire` is."""

WORDS: dict[str, str] = {
    "English": "fires?|wildfires?|flames?|blazes?|blazing|ablaze|inferno|burn|burns|burned|burnt|burning|smoke|smoky"
    "|evacuat(?:e|es|ed|ing|ion|ions)",
    "German": "feuers?|brände|brennt|brennen|brennend[a-z]*|flammen|rauch|evakuier[a-z]*",
    "French": "feu|feux|incendies?|flammes?|fumées?|brûl[a-zé]*|évacu[a-zé]*",
    "Spanish": "fuegos?|incendios?|humo|quema|queman|quemando|evacu[a-zéó]*",
    "Portuguese": "fogos?|incêndios?|fumaça|queimando|evacu[a-zçãõ]*",
    "Italian": "fuoco|fuochi|incendi|fiamme|brucia|bruciano|bruciando",
    "Russian": "пожар[а-я]*|огонь|огня|огн[её]м|пламя|горит|горят|дым|дыма|дымом|эвакуац[а-я]*|эвакуир[а-я]*",
}
"""Patterns of whole words, lower case."""

UNSPACED: dict[str, str] = {
    "Japanese": "火事|火災|火の手|火元|出火|発火|延焼|消火|燃え|燃焼|(?<![肺脳胃腸])炎(?![症天])|煙(?!草)|避難",
    "Chinese": "火灾|起火|着火|失火|大火|火焰|火势|火警|燃烧|燃燒|烟雾|浓烟|疏散|撤离|撤離|避难",
    "Korean": "화재|불이야|불이 났|불이 나|불길|화염|연기가|대피",
}
"""Patterns that match anywhere."""


def is_warning(text: str, fires: Iterable[str] = ()) -> bool:
    """Return whether a message is a warning.

    Args:
        text: the message.
        fires: names of the world's fires.
    """
    return _pattern(tuple(fires)).search(plain(text)) is not None


@lru_cache(maxsize=64)
def _pattern(fires: tuple[str, ...]) -> re.Pattern[str]:
    names = [_bounded(re.escape(plain(name)), plain(name)) for name in fires]
    return re.compile("|".join([*names, compiled(WORDS, UNSPACED)]))


def _bounded(pattern: str, name: str) -> str:
    """Return the pattern of a name, held to whole words where the name begins or ends with a letter."""
    before = f"(?<![{_IN_NAMES}])" if re.match(f"[{_IN_NAMES}]", name) else ""
    after = f"(?![{_IN_NAMES}])" if re.search(f"[{_IN_NAMES}]$", name) else ""
    return before + pattern + after
