"""Reads the decision in a text: a label, or a number from a range. A text with an unknown word decides nothing.

Reading takes time linear in the length of the text.
"""

import math
import re
import unicodedata
from functools import lru_cache
from typing import TypeAlias

from foundry.declared import Actions

Decided: TypeAlias = str | int | float
"""A decision: a label such as "go", a whole number, or a number with a fraction."""

LONGEST = 120
"""Maximum number of characters of a sentence that is read as a decision; longer sentences are not guessed."""

# fmt: off
_AROUND = frozenset((
    "i", "i'll", "i'm", "will", "shall", "am", "going", "to", "my", "me", "the", "is", "final", "this", "that's",
    "it's", "so", "therefore", "thus", "hence", "choose", "chose", "chosen", "choosing", "decide", "decided",
    "decision", "choice", "pick", "picked", "select", "selected", "action", "answer", "reply", "boxed", "round",
    "turn", "time", "week", "today", "tonight", "now", "hereby", "and", "be", "for", "ok", "okay", "simply", "just",
))
"""Words that may surround a decision without changing it."""
_UNITS = frozenset((
    "token", "tokens", "unit", "units", "point", "points", "coin", "coins", "ton", "tons", "tonne", "tonnes", "fish",
    "piece", "pieces", "dollar", "dollars",
))
"""Words that may follow a number as its unit, as in "5 tokens"."""
# fmt: on
_MARKS = re.compile(
    r"[*`\"“”„«»「」『』()\[\]{}<>!;:,\\|=]|(?<!\w)'|'(?!\w)|[.。、！：，](?=\s|$)|(?<![\w])[-–—•>#]+(?=\s|$)"
)
_PERFECT = re.compile(r"\b(?:have|i've) (?=decided |chosen |picked |selected )")
_NUMBER = re.compile(r"[$€£¥]?([-+]?\d{1,15}(?:\.\d{1,15})?)")
_SENTENCE = re.compile(r"(?<=[^\d][.!?])(?:[*_`\"'”)]{0,4})(?=\s)|(?<=[。！？])|\n")
_ENDED = re.compile(r"[.!?。！？][*_`\"'”)]{0,4}$")
_DOUBTS = re.compile(
    r"(?<!\w)(?:not|no|never|nobody|none|cannot|without|unless|if|or|but|however|instead|rather|although|though|yet|says?|said|\w+n't)"
    r"(?!\w)|\?"
)
"""Words that may revoke the statement before them."""
_REASON = re.compile(r"(?:Because|Since|Given|Considering|As|It|The|My reason\w*|Reason\w*|Explanation|Last)\b")
"""Words that begin a reason for a decision."""


def decided_value(value: object, actions: Actions, kind: str) -> Decided | None:
    """Return the decision that a value in a JSON reply means; None if this decision is uncertain or illegal."""
    if isinstance(value, list) and len(value) == 1:
        value = value[0]
    if isinstance(value, str):
        return value if value in actions.labels else _sole(value, actions, kind)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    if actions.labels:
        return str(value) if str(value) in actions.labels else None
    return as_legal(value, actions)


def is_exact(value: object, actions: Actions) -> bool:
    """Return whether a value in a reply's JSON object is exactly a legal decision."""
    if actions.labels:
        return isinstance(value, str) and value in actions.labels
    return isinstance(value, int | float) and not isinstance(value, bool) and as_legal(value, actions) is not None


def decided_text(text: str, actions: Actions, kind: str) -> Decided | None:
    """Return the decision that a text without a JSON object means, or None if that is uncertain.

    Sentences and lines must not name different decisions. The decision is in the last sentence; or in the first
    sentence, if the rest only gives reasons for it. A last sentence does not count if the line before it is unfinished.
    """
    parts = [part.strip() for part in _SENTENCE.split(text) if part.strip()]
    alone = {place: decided for place, part in enumerate(parts) if (decided := _sole(part, actions, kind)) is not None}
    if len(set(alone.values())) != 1:
        return None
    last = len(parts) - 1
    if last in alone and (last == 0 or _has_ended(parts[last - 1])):
        return alone[last]
    return alone[0] if 0 in alone and _explains(" ".join(parts[1:]), actions) else None


def as_legal(number: float, actions: Actions) -> int | float | None:
    """Return a number if it is a legal decision, else None."""
    low, high = -math.inf if actions.low is None else actions.low, math.inf if actions.high is None else actions.high
    if not math.isfinite(number) or not low <= number <= high:
        return None
    if not actions.whole:
        return float(number)
    return int(number) if float(number).is_integer() else None


def _sole(text: str, actions: Actions, kind: str) -> Decided | None:
    if len(text) > LONGEST or "?" in text or "？" in text:
        return None
    words = _words(text)
    decisions = _labels(words, actions.labels) if actions.labels else _numbers(words, actions, kind)
    return decisions.pop() if len(decisions) == 1 else None


def _labels(words: tuple[str, ...], labels: tuple[str, ...]) -> set[Decided]:
    """Return the labels that the words name; empty if a word is unknown. Labels with more words are matched first."""
    known = _label_words(labels)
    named: set[Decided] = set()
    place = 0
    while place < len(words):
        match = next((phrase for phrase in known if words[place : place + len(phrase)] == phrase), None)
        if match is None and words[place] not in _AROUND:
            return set()
        if match is not None:
            named.add(known[match])
        place += len(match) if match else 1
    return named


def _numbers(words: tuple[str, ...], actions: Actions, kind: str) -> set[Decided]:
    """Return the set with the legal number that the words name; empty if they name several or a word is unknown."""
    numbers = [match[1] for word in words if (match := _NUMBER.fullmatch(word))]
    others = {word for word in words if not _NUMBER.fullmatch(word)}
    if len(numbers) != 1 or others - _AROUND - _UNITS - set(_words(kind)):
        return set()
    legal = as_legal(float(numbers[0]), actions)
    return set() if legal is None else {legal}


@lru_cache(maxsize=256)
def _label_words(labels: tuple[str, ...]) -> dict[tuple[str, ...], str]:
    """Return each label by its words, the labels with most words first, so that these are matched first."""
    words = {_words(label): label for label in labels}
    return {word: words[word] for word in sorted(words, key=len, reverse=True) if word}


def _words(text: str) -> tuple[str, ...]:
    plain = _PERFECT.sub("", _MARKS.sub(" ", _plain(text)))
    return tuple(word for part in plain.split() if (word := part.rstrip(".。、！…")))


def _plain(text: str) -> str:
    return unicodedata.normalize("NFKC", text).casefold().replace("’", "'").replace("_", " ")


def _has_ended(part: str) -> bool:
    """Return whether a part of a text is a complete sentence, or announces a decision, as in "My decision:"."""
    return bool(_ENDED.search(part)) or (part.endswith((":", "：", ":**", ":*")) and set(_words(part)) <= _AROUND)


def _explains(text: str, actions: Actions) -> bool:
    """Return whether a text after a decision only gives reasons for it, without any doubt or other action."""
    return bool(_REASON.match(text)) and not _DOUBTS.search(_plain(text)) and not _mentions(text, actions)


def _mentions(text: str, actions: Actions) -> bool:
    words = _words(text)
    if not actions.labels:
        return any(_NUMBER.search(word) for word in words)
    return any(
        words[place : place + len(label_word)] == label_word
        for label_word in _label_words(actions.labels)
        for place in range(len(words))
    )
