"""Numbers and units among the tokens, merged into amounts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from foundry.worlds.camera.language.tokens import Token
from foundry.worlds.camera.language.words import Dimension, Kind, Word

LARGEST = 1e6
"""Metres or degrees; a larger amount is read as this one."""

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
        number: metres, degrees, steps, or the plain number.
        dimension: what the unit measures, None without one.
        remark: what had to be decided to read it, or "".
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
    """Return the tokens with every number and its unit as one `Amount`."""
    merged: list[Token] = []
    position = 0
    while position < len(tokens):
        found = _amount(tokens, position)
        if found is None:
            merged.append(tokens[position])
            position += 1
        else:
            amount, position = found
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
    """Read "1-2", "1 to 2", "between 1 and 2": the smaller number, with a remark."""
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
    """Read number words: "one hundred and eighty", "two and a half", "three quarters of a", 百八十."""
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
    """Return where "of a" or "a" ends, when a unit follows: "half a metre", "a couple of steps"."""
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
    """Return where "and a half" ends, or None."""
    for length in (3, 2, 1):
        if tuple(token.text for token in tokens[at : at + length]) in _HALVES:
            return at + length
    return None
