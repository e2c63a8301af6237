"""Finds the sentences that may name a movement; linear in the length of the text."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from foundry.worlds.camera.language.tokens import Token, command_words, tokens, with_amounts
from foundry.worlds.camera.language.words import Kind

MAX_WORDS = 1000
"""Words that may name a movement which are looked at, the last ones of the text."""

MAX_REACH = 500
"""Characters before and after such a word that are taken for its sentence."""

_AT_CUT = 20
"""Tokens that are left out where a sentence had to be cut, for they may be parts of others."""

_NUMERIC = (Kind.DIGITS, Kind.NUMBER, Kind.UNIT)
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
        cut: whether it was too long to be read to its end.
    """

    segments: Sequence[Segment]
    question: bool
    whole: bool
    cut: bool


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
        goes_on = found[-1].cut if found and start == read_to else False
        read_to = end.end() if end else min(len(text), match.end() + MAX_REACH)
        whole = not goes_on and (start == 0 or bool(_END.match(text, start - 1)))
        cut = end is None and read_to < len(text)
        found.append(_sentence(text[start:read_to], whole=whole, goes_on=goes_on, cut=cut))
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


def _sentence(text: str, *, whole: bool, goes_on: bool, cut: bool) -> Sentence:
    """Return a sentence; where it had to be cut, without what lies at the cut."""
    found = with_amounts(_without_asides(tokens(text)))
    segments = _segments(found[:-_AT_CUT] if cut else found)
    return Sentence(segments[1:] if goes_on else segments, text.endswith("?"), whole, cut)


def _without_asides(found: Sequence[Token]) -> list[Token]:
    """Drop what repeats an amount in brackets: "two (2) metres", "2 m (about 6 feet) forward"."""
    kept: list[Token] = []
    position = 0
    while position < len(found):
        token = found[position]
        if token.text == "(" and kept and kept[-1].kind in _NUMERIC:
            inner = position + 1
            while inner < len(found) and found[inner].kind in (*_NUMERIC, Kind.BY, Kind.FILLER, Kind.ARTICLE):
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
