"""Finds the sentences that may name a movement; linear in the length of the text."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from foundry.worlds.usd.language.amounts import with_amounts
from foundry.worlds.usd.language.tokens import Token, command_words, tokens
from foundry.worlds.usd.language.words import Kind

MAX_WORDS = 1000
"""Words that may name a movement which are looked at, the last ones of the text."""

MAX_REACH = 500
"""Characters before and after such a word that are taken for its sentence."""

_END = re.compile(r"[!?;。\n]|\.(?!\d)")


@dataclass(frozen=True, slots=True)
class Segment:
    """A part of a sentence between two joints.

    Attributes:
        joint: the token before it, None at the start of the sentence.
        tokens: its tokens.
        text: as read.
    """

    joint: Token | None
    tokens: Sequence[Token]

    @property
    def text(self) -> str:
        """Its words."""
        return " ".join(token.text for token in self.tokens)


@dataclass(frozen=True, slots=True)
class Sentence:
    """A sentence, cut at its joints.

    Attributes:
        segments: its parts in order.
        question: whether it ends with a question mark.
        whole: whether it was read from its beginning.
    """

    segments: Sequence[Segment]
    question: bool
    whole: bool


def find_sentences(text: str) -> list[Sentence]:
    """Return the sentences of a cleaned text in which a movement may be named, in order."""
    found: list[Sentence] = []
    read_to = 0
    for match in deque(command_words(text), maxlen=MAX_WORDS):
        if match.start() < read_to:
            continue
        first = max(read_to, match.start() - MAX_REACH)
        before = list(_END.finditer(text, first, match.start()))
        start = before[-1].end() if before else first
        end = _END.search(text, match.end(), match.end() + MAX_REACH)
        read_to = end.end() if end else min(len(text), match.end() + MAX_REACH)
        whole = start == 0 or bool(_END.match(text, start - 1))
        found.append(_sentence(text[start:read_to], end is not None and end[0] == "?", whole))
    return found


def last_sentence(text: str) -> str:
    """Return the last sentence of a cleaned text that holds a letter or a digit, or ""."""
    last = len(text)
    while last and not text[last - 1].isalnum():
        last -= 1
    end, low = _END.search(text, last), last
    while low:
        high, low = low, max(0, low - MAX_REACH)
        ends = list(_END.finditer(text, low, high))
        if ends:
            low = ends[-1].end()
            break
    return text[low : end.end() if end else len(text)] if last else ""


def _sentence(text: str, question: bool, whole: bool) -> Sentence:
    return Sentence(_segments(_without_asides(with_amounts(tokens(text)))), question, whole)


def _without_asides(found: Sequence[Token]) -> list[Token]:
    """Drop an amount in brackets right behind an amount: "2 m (about 6 feet) forward"."""
    kept: list[Token] = []
    position = 0
    while position < len(found):
        token = found[position]
        if token.text == "(" and kept and kept[-1].kind is Kind.AMOUNT:
            inner = position + 1
            while inner < len(found) and found[inner].kind in (Kind.AMOUNT, Kind.BY, Kind.FILLER):
                inner += 1
            if inner < len(found) and found[inner].text == ")":
                position = inner + 1
                continue
        kept.append(token)
        position += 1
    return kept


def _segments(found: Sequence[Token]) -> list[Segment]:
    segments: list[Segment] = []
    joint: Token | None = None
    current: list[Token] = []
    for token in found:
        if token.kind in (Kind.JOIN, Kind.OR, Kind.BREAK):
            if current:
                segments.append(Segment(joint, current))
                joint, current = token, []
            elif joint is None or token.kind is not Kind.BREAK:
                joint = token
        else:
            current.append(token)
    if current:
        segments.append(Segment(joint, current))
    return segments
