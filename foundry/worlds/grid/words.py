"""Reads lines such as "action: stay", and the meaning of words; an unknown word makes a decision unreadable."""

import json
import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import msgspec

from foundry.worlds.replies import merged


class _Words(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The known words, from `words.toml`; in this file, a bar or a line break separates words."""

    keys: dict[str, str]
    meanings: dict[str, str]
    fillers: str
    not_moving: str
    silence: str
    placeholders: str


def _split(words: str) -> tuple[str, ...]:
    return tuple(re.split(r" \| |\n", words.rstrip("\n")))


_WORDS = msgspec.toml.decode(Path(__file__).with_name("words.toml").read_bytes(), type=_Words)
UP, DOWN, LEFT, RIGHT, STAY, MOVE = "up", "down", "left", "right", "stay", "move"
MEANINGS = {meaning: _split(words) for meaning, words in _WORDS.meanings.items()}
NOT_MOVING = frozenset(_split(_WORDS.not_moving))
SILENCE = frozenset(_split(_WORDS.silence))

REMARKS = (
    "(", "[", ",", ":", ";", ".", "-", "–", "—", "//", "#", "/*",
    "toward", "because", "since", "so ", "as ", "to ",
)  # fmt: skip
"""Beginnings of a remark after any decision, as in "up (safer)"; the remark does not change the decision."""
STAYING_REMARKS = ("in ", "at ", "here", "inside", "within", "on ", "for ", "until", "where", "there")
"""Beginnings of a remark after a decision to stay, as in "stay here"; the remark does not change the decision."""

DOUBTS = frozenset(
    ("not", "no", "don't", "dont", "never", "or", "unless", "if", "maybe", "perhaps", "possibly", "either", "then",
     "instead", "away", "except", "but", "later", "nicht", "oder", "vielleicht", "ou", "pas", "o", "не", "или",
     "または", "か", "或", "不", "또는")
)  # fmt: skip
"""Words in a remark that cast doubt on the decision before it."""

NO_DIRECTION = frozenset(("", "null", "none", "n/a", "na", "nil", "-", "--", "no direction", "なし", "无", "無"))

BLANKS = frozenset(("message", "text", "string", "content", "your", "insert", "optional", "brief", "short"))
"""Words of placeholders: "<your message>" contains such words, but "<fire near cafe>" is a real message."""

_DIRECTIONS = frozenset((UP, DOWN, LEFT, RIGHT))
_LONGEST = 120
"""Maximum number of characters of a key or value; the meaning of a longer one is not guessed."""

_MOST_PARTS = 4
"""Maximum number of texts in a list or object that stands for one text, such as ["move", "up"] for "move up"."""

_GENERIC = frozenset(("", "type", "name", "value", "action", "direction", "move", "kind"))
_FILLER = ""
_AXIS = re.compile(r"\s*([+-])\s*(?=1(?!\d)|[xy](?!\w))")
_CHANGE = re.compile(r"\b([xy])\s*=\s*\1\s*([+-])")
_INVISIBLE = re.compile("[\ufe0e\ufe0f\u200b-\u200d\u2060\ufeff]")
_SKIPPED = re.compile(r"(?:[\s\"'`*_.,:;!()\[\]{}/|~“”„«»「」『』。、・]|-(?![xy]\b))+")
_LETTERS = re.compile(r"[^\W\d_]+(?:'[^\W\d_]+)?")
_AROUND = " \t\r\n.!*_'\"`()[]<>{}-“”「」。（）【】"
_SPACES = re.compile(r"[\W_]+")


@dataclass(frozen=True, slots=True)
class Meaning:
    """An action, to stay or to move, and the direction of a move."""

    action: str
    direction: str | None


@dataclass(frozen=True, slots=True)
class _Phrase:
    """A known phrase in a text: its meaning, and the index in the text at which it ends."""

    meaning: str
    end: int


_REMEMBERED = 4096
"""Maximum number of cached texts; the cache helps, since almost all replies contain the same keys and values."""

_STAYING = Meaning("stay", None)
_MEANINGS = dict.fromkeys(_split(_WORDS.fillers), _FILLER) | {
    word: meaning for meaning, words in MEANINGS.items() for word in words
}
_KEYS = {name: key for key, names in _WORDS.keys.items() for name in _split(names)}


def _bounded(word: str) -> str:
    """Return the pattern of a phrase; in Latin and Cyrillic letters it matches only whole words."""
    before, after = ("" if _joins(word[end]) else bound for end, bound in ((0, r"(?<!\w)"), (-1, r"(?!\w)")))
    return before + re.escape(word) + after


def _joins(character: str) -> bool:
    return not unicodedata.name(character, "").startswith(("LATIN", "CYRILLIC", "DIGIT"))


@cache
def _phrase() -> re.Pattern[str]:
    """Return the pattern that matches any known phrase; it is compiled on first use, which takes milliseconds."""
    return re.compile("|".join(_bounded(word) for word in sorted(_MEANINGS, key=len, reverse=True)))


@lru_cache(maxsize=_REMEMBERED)
def key_of(name: str) -> str | None:
    """Return the requested key that a name means, such as "action" for "Entscheidung"; else None."""
    if len(name) > _LONGEST:
        return None
    return _KEYS.get(_plain(name).strip(_AROUND).replace("_", " "))


def understand(action: object, direction: object) -> Meaning | None:
    """Return the action that a reply's keys "action" and "direction" mean together; None if it is uncertain.

    Either value may give the direction, but the two must not give different directions.
    """
    asked, wanted = _text(action), _text(direction)
    given = direction is not None and wanted not in NO_DIRECTION
    if asked in NOT_MOVING:
        return None if given else _STAYING
    words = None if asked is None else _words(asked)
    if not words or STAY in words and len(words) > 1:
        return None
    if STAY in words:
        return _STAYING
    further = frozenset[str]() if not given else None if wanted is None else _words(wanted)
    if further is None or STAY in further:
        return None
    directions = (words | further) & _DIRECTIONS
    return Meaning("move", *directions) if len(directions) == 1 else None


def is_silence(message: str) -> bool:
    """Return whether a message only says that there is no message."""
    said = _plain(message[: _LONGEST + 1]).strip(_AROUND + "…")
    return said in SILENCE or not said


def is_placeholder(message: str) -> bool:
    """Return whether a message only copies a placeholder of the prompt, such as "<your message>", or its beginning."""
    said = _SPACES.sub(" ", message[:_LONGEST].lower()).strip()
    bracketed = message.strip().startswith("<") and message.strip().endswith(">")
    return said in _COPIED or (bracketed and (not said or not BLANKS.isdisjoint(said.split())))


_PLACEHOLDERS = tuple(_SPACES.sub(" ", known.lower()).strip() for known in _split(_WORDS.placeholders))
_TELLING = 12
"""A message that is cut after this many characters still counts as a copy of a placeholder."""
_COPIED = frozenset(known[:end] for known in _PLACEHOLDERS for end in range(min(len(known), _TELLING), len(known) + 1))


@lru_cache(maxsize=_REMEMBERED)
def _plain(text: str) -> str:
    return _INVISIBLE.sub("", unicodedata.normalize("NFKC", text)).lower().replace("’", "'").strip()


def _text(value: object) -> str | None:
    """Return the normalised text of a value, which may be a short list or object of texts; else None."""
    if isinstance(value, dict):
        value = [
            part
            for key, part_value in value.items()
            for part in (key if key.lower() not in _GENERIC else "", part_value)
        ]
        value = [part for part in value if part not in ("", None)]
    if isinstance(value, list):
        few = 0 < len(value) <= _MOST_PARTS and all(isinstance(part, str) for part in value)
        value = " , ".join(value) if few else None
    return _spelled(value) if isinstance(value, str) and len(value) <= _LONGEST else None


@lru_cache(maxsize=_REMEMBERED)
def _spelled(text: str) -> str:
    return _AXIS.sub(r"\1", _CHANGE.sub(r"\1\2", _plain(text).replace("_", " "))).strip(" \"'")


@lru_cache(maxsize=_REMEMBERED)
def _words(text: str) -> frozenset[str] | None:
    """Return the meanings of the words in a text, or None if it has an unknown word outside a remark."""
    phrases = list(_phrases(text))
    telling = [number for number, phrase in enumerate(phrases) if phrase.meaning != _FILLER]
    meanings = frozenset(phrases[number].meaning for number in telling)
    end = phrases[-1].end if phrases else 0
    if not _SKIPPED.sub("", text[end:]):
        return meanings
    if not telling:
        return None
    return meanings if _is_remark(text[phrases[telling[-1]].end :].lstrip(" \"'*`"), meanings) else None


def _phrases(text: str) -> Iterator[_Phrase]:
    """Yield the known phrases at the beginning of a text, up to the first unknown word."""
    position, phrase = 0, _phrase()
    while True:
        skipped = _SKIPPED.match(text, position)
        match = phrase.match(text, position) or (skipped and phrase.match(text, skipped.end()))
        if not match:
            return
        position = match.end()
        yield _Phrase(_MEANINGS[match[0]], position)


def _is_remark(rest: str, meanings: frozenset[str]) -> bool:
    """Return whether the text after a decision is a remark that does not change the decision."""
    opening = (*REMARKS, *STAYING_REMARKS) if meanings == {STAY} else REMARKS
    if not rest.startswith(opening) or "?" in rest or DOUBTS & set(_LETTERS.findall(rest)):
        return False
    said = {_MEANINGS[match[0]] for match in _phrase().finditer(rest)} - {_FILLER}
    return said <= meanings | (set() if STAY in meanings else {MOVE})


_MOST = 32
"""Maximum number of labels such as "action:" in a text. A text with more labels contains no clear decision."""

_NAMES = "|".join(
    re.escape(name) for names in _WORDS.keys.values() for name in sorted(_split(names), key=len, reverse=True)
)
_LABEL = re.compile(
    r"(?:^|(?<=[,;|{}])|(?<=[\s\"'”])(?=[\"'“]))"
    r"[ \t>|{*•#\d.)_`\"'“-]{0,12}+(?:(?:my|your|the|final|next|chosen)[ ]){0,2}"
    rf"({_NAMES})[ \t*_`\"'”]{{0,6}}+[:：=](?!=)[ \t*_`]*+",
    re.IGNORECASE | re.MULTILINE,
)
_LABEL_END = re.compile("[:：=]")
_TAG = re.compile(rf"<(/?)\s*+({_NAMES})\s*+>", re.IGNORECASE)
_HEADING = re.compile(
    rf"^[ \t]{{0,8}}+(?:#{{1,6}}+[ \t]{{0,4}}+\**|\*\*)({_NAMES})\**[ \t]{{0,8}}+$", re.IGNORECASE | re.MULTILINE
)
_FENCE = re.compile(r"^[ \t]{0,8}+```\w{0,20}+[ \t]{0,8}+$", re.MULTILINE)
_ESCAPES = re.compile(r'(?:\\u[0-9a-fA-F]{4})+|\\["\\/bfnrt]')
_BLANK_LINE = re.compile(r"\n[ \t]*+\n")
_COMMENT = re.compile(r"""(["'”]|\bnull|\bnone)\s*+,?\s*+(?://|\#|/\*)[^\n]{0,200}+\s*+\Z""", re.IGNORECASE)
_MARKUP = " \t\r\n*_`,"
_QUOTES = (('"', '"'), ("'", "'"), ("“", "”"), ("「", "」"), ("«", "»"))


def labelled_values(text: str, *, cut: bool) -> dict[str, Any]:
    """Return the texts after labels, by the keys that the labels mean: {"action": "stay"} for "Action: stay".

    Args:
        text: a reply without an object.
        cut: whether the reply was cut; the last value of a cut reply may be incomplete, so this value is left out.

    Returns:
        A `Conflicting` object if a key has several texts.
    """
    text = _TAG.sub(lambda tag: "\n" if tag[1] else f"\n{tag[2]}: ", _FENCE.sub("", text))
    text = _HEADING.sub(r"\1: ", text)
    labels = list(_LABEL.finditer(text)) if _LABEL_END.search(text) else []
    if not labels or len(labels) > _MOST:
        return {}
    ends = [label.start() for label in labels[1:]] + [len(text)]
    pairs = [(key_of(label[1]) or "", text[label.end() : end]) for label, end in zip(labels, ends, strict=True)]
    if cut or pairs[-1][0] == "message" and _BLANK_LINE.search(pairs[-1][1].strip()):
        pairs.pop()
    return merged([(key, _value(key, value)) for key, value in pairs])


def _value(key: str, text: str) -> str:
    """Return a value without markup and the comment after it; for a decision, return only its first line."""
    text = _COMMENT.sub(r"\1", text)
    value = text.strip(_MARKUP).removesuffix("}").strip(_MARKUP)
    if key in ("action", "direction"):
        value = value.split("\n", 1)[0].strip(_MARKUP)
    for opening, closing in _QUOTES:
        if len(value) > 1 and value.startswith(opening) and value.endswith(closing):
            return _ESCAPES.sub(lambda match: str(json.loads(f'"{match[0]}"')), value[1:-1])
    return value
