"""Splits a cleaned text into sentences, segments and tokens, and merges numbers and units into amounts.

Only sentences that may name a movement are read. One regular expression finds the words of all languages. The reading
time is proportional to the length of the text.
"""

import math
import os
import re
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

from foundry.worlds.camera.language.lexicon import LEXICON, Act, Dimension, Kind, Word

_CJK = "\u3005\u3007\u3040-\u30ff\u3400-\u9fff"
LETTER = rf"[^\W\d_{_CJK}]"
_COMMANDING = (Kind.VERB, Kind.WAY, Kind.STAY, Kind.DONE, Kind.PAUSE, Kind.RETRACT)


@dataclass(frozen=True, slots=True)
class Token:
    """A word or phrase of the text and its meaning.

    Attributes:
        text: text of the token in lower case.
        number: value of the digits.
        signed: whether the digits have a sign.
    """

    word: Word
    text: str
    number: float = 0.0
    signed: bool = False

    @property
    def kind(self) -> Kind:
        """The role of the token in the sentence."""
        return self.word.kind


def _alternatives(names: Iterable[str]) -> str:
    """Return a regular expression for any of the names, the longest first; Latin names match whole words only."""
    latin: list[str] = []
    other: list[str] = []
    for name in sorted(names):
        (latin if re.fullmatch(LETTER, name[0]) else other).append(name)
    first = "".join(sorted({name[0] for name in latin}))
    return rf"(?=[{first}])(?<!{LETTER}){_branches(latin)}(?!{LETTER})|{_branches(other)}"


def _branches(names: Sequence[str]) -> str:
    """Return a regular expression for sorted names; for speed, it states a beginning that names share only once."""
    shared = os.path.commonprefix(names)
    rests = [name[len(shared) :] for name in names]
    ends = "" in rests
    by_first = [[*group] for _, group in groupby(filter(None, rests), key=lambda rest: rest[0])]
    if not by_first:
        return re.escape(shared)
    branches = "|".join(_branches(group) for group in by_first)
    return f"{re.escape(shared)}(?:{branches}){'?' if ends else ''}"


_PI = r"(?:\d+(?:\.\d+)? ?\*? ?)?(?:π|pi(?![^\W\d_]))(?: ?/ ?\d{1,9})?"
_NUMBER = (
    rf"(?:(?<![^\s(:=,])[-+])?(?:(?<![^\W\d_]){_PI}|" + r"\d{1,9} ?/ ?\d{1,9}(?![\d.,/])|\d+(?:[.,]\d+)*|(?<!\d)\.\d+)"
)
_TOKEN = re.compile(
    rf"(?P<digits>{_NUMBER})|(?P<known>{_alternatives(LEXICON)})|(?P<unknown>{LETTER}+|[{_CJK}])"
    r"|(?P<or>/)|(?P<range>(?<=\d)-(?=\d)|\^)|(?P<mark>->|=>| - |[,:()\[\]{}=、・])"
)
_COMMAND = re.compile(
    _alternatives(
        name
        for name, word in LEXICON.items()
        if (word.kind in _COMMANDING and word.act is not Act.MAKE) or word.dimension is Dimension.STEP
    )
)
_UNKNOWN, _DIGITS = Word(Kind.UNKNOWN), Word(Kind.DIGITS)
_ADVERB, _SHORTEST_ADVERB = Word(Kind.FILLER), 5
_SIGNS = {"or": Word(Kind.OR), "range": Word(Kind.UNKNOWN), "mark": Word(Kind.BREAK), "unknown": _UNKNOWN}


def tokens(text: str) -> list[Token]:
    """Return the words, numbers and marks of a cleaned text."""
    return [_token(match) for match in _TOKEN.finditer(text)]


def _token(match: re.Match[str]) -> Token:
    text = match[0]
    if match.lastgroup == "known":
        return Token(LEXICON[text], text)
    if match.lastgroup == "digits":
        value = _value(text.lstrip("+-"))
        if value is None:
            return Token(_UNKNOWN, text)
        return Token(_DIGITS, text, -value if text[0] == "-" else value, text[0] in "+-")
    if text.endswith("ly") and len(text) > _SHORTEST_ADVERB:
        return Token(_ADVERB, text)
    return Token(_SIGNS[match.lastgroup or "unknown"], text)


def _value(digits: str) -> float | None:
    """Return the value of a number with a decimal point or comma, thousands separators, a fraction bar or pi."""
    if "π" in digits or "pi" in digits:
        times, bottom = re.split(r"π|pi", digits.replace("*", "").replace(" ", ""))
        below = float(bottom.lstrip("/") or 1)
        return float(times or 1) * math.pi / below if below else None
    top, bar, bottom = digits.partition("/")
    if bar:
        return float(top) / float(bottom) if float(bottom) else None
    if re.fullmatch(r"[1-9]\d{0,2}(?:,\d{3})+(?:\.\d+)?", digits):
        return float(digits.replace(",", ""))
    return float(digits.replace(",", ".")) if len(re.findall(r"[.,]", digits)) < 2 else None


LARGEST = 1e6
"""Largest amount, in metres or degrees; a larger amount is replaced by this value."""

_AMOUNT = Word(Kind.AMOUNT)
_INCH = Word(Kind.UNIT, number=0.0254, dimension=Dimension.LENGTH)
_STEP = Word(Kind.UNIT, number=1.0, dimension=Dimension.STEP)
_ADJECTIVES = frozenset(
    ("more", "further", "small", "short", "large", "big", "good", "whole", "full", "additional", "extra")
)
_HALVES = frozenset((("and", "a", "half"), ("and", "half"), ("半",)))
_ENDS = (Kind.BREAK, Kind.JOIN, Kind.OR, Kind.WAY)


@dataclass(frozen=True, slots=True)
class Amount(Token):
    """A number with its unit.

    Attributes:
        number: metres, degrees or steps; without a unit, the plain number.
        dimension: quantity of the unit, or None without a unit.
        remark: note on how the amount was read, or "".
    """

    dimension: Dimension | None = None
    remark: str = ""


@dataclass(frozen=True, slots=True)
class _Number:
    value: float
    end: int
    signed: bool = False
    article: bool = False
    remark: str = ""


def with_amounts(tokens: Sequence[Token]) -> list[Token]:
    """Return the tokens, with each number and its unit replaced by one `Amount`."""
    merged: list[Token] = []
    position = 0
    while position < len(tokens):
        read = _amount(tokens, position)
        if read is None:
            merged.append(tokens[position])
            position += 1
        else:
            amount, position = read
            merged.append(amount)
    return merged


def _amount(tokens: Sequence[Token], start: int) -> tuple[Amount, int] | None:
    number = _range(tokens, start)
    if number is None:
        return None
    unit_at = number.end
    while unit_at < len(tokens) and tokens[unit_at].text in _ADJECTIVES:
        unit_at += 1
    unit = _unit(tokens, unit_at)
    if unit is None:
        if number.article:
            return None
        return _made(tokens, start, number.end, number, Word(Kind.UNIT, number=1.0)), number.end
    end = unit_at + 1
    rest = _half(tokens, end)
    if rest:
        number = _Number(number.value + 0.5, rest, number.signed, remark=number.remark)
        end = rest
    return _made(tokens, start, end, number, unit), end


def _made(tokens: Sequence[Token], start: int, end: int, number: _Number, unit: Word) -> Amount:
    text = " ".join(token.text for token in tokens[start:end])
    value = number.value if unit.number in (0.0, 1.0) else round(number.value * unit.number, 9)
    remark = number.remark or ("'few' is read as 3" if "few" in text.split() else "")
    return Amount(_AMOUNT, text, max(-LARGEST, min(value, LARGEST)), number.signed, unit.dimension, remark)


def _unit(tokens: Sequence[Token], at: int) -> Word | None:
    if at >= len(tokens):
        return None
    token = tokens[at]
    if token.kind is Kind.UNIT:
        return token.word
    if token.text == "step":
        return _STEP
    follows = tokens[at + 1].kind if at + 1 < len(tokens) else Kind.BREAK
    return _INCH if token.text == "in" and follows in _ENDS else None


def _range(tokens: Sequence[Token], start: int) -> _Number | None:
    """Read a number, or a range such as "1-2" or "between 1 and 2" as its smaller number, with a remark."""
    first = _number(tokens, start)
    if first is None or first.article or first.end + 1 >= len(tokens):
        return first
    between = start > 0 and tokens[start - 1].text == "between" and tokens[first.end].text == "and"
    if not between and tokens[first.end].text not in ("-", "to", "or", "bis", "から"):
        return first
    second = _number(tokens, first.end + 1)
    if second is None or second.article or (second.signed and tokens[first.end].text != "-"):
        return first
    if tokens[first.end].text != "-" and _unit(tokens, second.end) is None:
        return first
    return _Number(min(first.value, second.value), second.end, remark="of a range its smaller number")


def _number(tokens: Sequence[Token], start: int) -> _Number | None:
    token = tokens[start]
    if token.kind is Kind.DIGITS:
        return _digits(tokens, start)
    if token.kind is Kind.NUMBER:
        return _words(tokens, start)
    if token.kind is not Kind.ARTICLE or start + 1 >= len(tokens):
        return None
    following = tokens[start + 1]
    if following.kind is Kind.NUMBER or following.kind is Kind.DIGITS:
        return _number(tokens, start + 1)
    return _Number(1.0, start + 1, article=True)


def _digits(tokens: Sequence[Token], start: int) -> _Number:
    token, end = tokens[start], start + 1
    value = token.number
    if end < len(tokens) and tokens[end].kind is Kind.DIGITS and "/" in tokens[end].text and "/" not in token.text:
        value, end = value + tokens[end].number, end + 1
    half = _half(tokens, end)
    return _Number(value + 0.5 if half else value, half or end, token.signed)


def _words(tokens: Sequence[Token], start: int) -> _Number:
    """Read a number in words, such as "one hundred and eighty", "two and a half", "three quarters of a", 百八十."""
    total = pending = 0.0
    at = start
    while at < len(tokens):
        token = tokens[at]
        if token.kind is not Kind.NUMBER:
            if not (token.text == "and" and total and not pending and _is_whole(tokens, at + 1)):
                break
        elif token.word.scale:
            total, pending = total + max(pending, 1.0) * token.word.number, 0.0
        elif token.word.number < 1 and token.word.number:
            total, pending, at = total + max(pending, 1.0) * token.word.number, 0.0, _after_of(tokens, at + 1)
            return _Number(total, at)
        elif pending and not (pending >= 20 and pending % 10 == 0 and token.word.number < 10):
            break
        else:
            pending += token.word.number
        at += 1
    value = total + pending
    if at + 1 < len(tokens) and tokens[at].kind is Kind.POINT and tokens[at + 1].kind is Kind.NUMBER:
        return _decimals(tokens, at + 1, value)
    half = _half(tokens, at)
    end = half or at
    return _Number(value + 0.5 if half else value, _after_of(tokens, end))


def _is_whole(tokens: Sequence[Token], at: int) -> bool:
    return at < len(tokens) and tokens[at].kind is Kind.NUMBER and tokens[at].word.number >= 1


def _after_of(tokens: Sequence[Token], at: int) -> int:
    """Return the index after "of a" or "a" if a unit follows, as in "half a metre" or "a couple of steps"."""
    end = at
    if end < len(tokens) and tokens[end].kind is Kind.OF:
        end += 1
    if end < len(tokens) and tokens[end].kind is Kind.ARTICLE:
        end += 1
    return end if end < len(tokens) and (_unit(tokens, end) or tokens[end].text == "turn") else at


def _decimals(tokens: Sequence[Token], at: int, whole: float) -> _Number:
    digits = ""
    while (
        at < len(tokens)
        and tokens[at].kind is Kind.NUMBER
        and tokens[at].word.number < 10
        and not tokens[at].word.scale
    ):
        digits += f"{tokens[at].word.number:.0f}"
        at += 1
    return _Number(float(f"{whole:.0f}.{digits}") if digits else whole, at)


def _half(tokens: Sequence[Token], at: int) -> int | None:
    """If the words "and a half" begin at index `at`, return the index after them; else None."""
    for length in (3, 2, 1):
        if tuple(token.text for token in tokens[at : at + length]) in _HALVES:
            return at + length
    return None


MAX_WORDS = 1000
"""Largest number of words that may name a movement. In a text with more such words, only the last ones are read."""

MAX_REACH = 500
"""The ends of a sentence are searched in this number of characters before and after a word that may name a movement."""

_AT_CUT = 20
"""Number of tokens that foundry ignores at the end of a sentence that was cut, since they may be incomplete."""

_NUMERIC = (Kind.DIGITS, Kind.NUMBER, Kind.UNIT)
_END = re.compile(r"[!?;。\n]|\.(?!\d)")


@dataclass(frozen=True, slots=True)
class Segment:
    """A part of a sentence. A joint between two parts is a comma, another mark, or a word such as "and".

    Attributes:
        joint: the joint before the segment; None at the start of the sentence.
    """

    joint: Token | None
    tokens: Sequence[Token]

    @property
    def text(self) -> str:
        """The words of the segment."""
        return " ".join(token.text for token in self.tokens)


@dataclass(frozen=True, slots=True)
class Sentence:
    """A sentence, split into segments at commas, other marks, and words such as "and".

    Attributes:
        question: whether the sentence ends with a question mark.
        whole: whether the sentence was read from its beginning.
        cut: whether the sentence was too long to be read to its end.
    """

    segments: Sequence[Segment]
    question: bool
    whole: bool
    cut: bool


def find_sentences(text: str) -> list[Sentence]:
    """Return the sentences of a cleaned text that may name a movement, in order."""
    sentences: list[Sentence] = []
    read_to = 0
    for match in deque(_COMMAND.finditer(text), maxlen=MAX_WORDS):
        if match.start() < read_to:
            continue
        first = max(read_to, match.start() - MAX_REACH)
        before = list(_END.finditer(text, first, match.start()))
        start = before[-1].end() if before else first
        end = _END.search(text, match.end(), match.end() + MAX_REACH)
        goes_on = sentences[-1].cut if sentences and start == read_to else False
        read_to = end.end() if end else min(len(text), match.end() + MAX_REACH)
        whole = not goes_on and (start == 0 or bool(_END.match(text, start - 1)))
        cut = end is None and read_to < len(text)
        sentences.append(_sentence(text[start:read_to], whole=whole, goes_on=goes_on, cut=cut))
    return sentences


def last_sentence(text: str) -> str:
    """Return the last sentence of a cleaned text that has a letter or a digit, or ""."""
    ends = [0, *(match.end() for match in _END.finditer(text)), len(text)]
    sentences = (text[start:end] for start, end in reversed([*pairwise(ends)]))
    return next((sentence for sentence in sentences if any(map(str.isalnum, sentence))), "")


def _sentence(text: str, *, whole: bool, goes_on: bool, cut: bool) -> Sentence:
    amounts = with_amounts(_without_asides(tokens(text)))
    segments = _segments(amounts[:-_AT_CUT] if cut else amounts)
    return Sentence(segments[1:] if goes_on else segments, text.endswith("?"), whole, cut)


def _without_asides(all_tokens: Sequence[Token]) -> list[Token]:
    """Remove an amount in brackets after the same amount, as in "two (2) metres" and "2 m (about 6 feet)"."""
    outside: list[Token] = []
    position = 0
    while position < len(all_tokens):
        token = all_tokens[position]
        if token.text == "(" and outside and outside[-1].kind in _NUMERIC:
            inner = position + 1
            while inner < len(all_tokens) and all_tokens[inner].kind in (*_NUMERIC, Kind.BY, Kind.FILLER, Kind.ARTICLE):
                inner += 1
            if inner < len(all_tokens) and all_tokens[inner].text == ")":
                position = inner + 1
                continue
        outside.append(token)
        position += 1
    return outside


def _segments(all_tokens: Sequence[Token]) -> list[Segment]:
    segments: list[Segment] = []
    joint: Token | None = None
    current: list[Token] = []
    for token in all_tokens:
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
