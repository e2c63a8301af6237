"""From text to tokens: the tables of all languages in one expression.

First it leaves out what a text quotes of earlier steps, and what it lists to choose from. Last it merges numbers and
units into amounts.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby

from foundry.worlds.camera.language.chinese import CHINESE
from foundry.worlds.camera.language.english import ENGLISH
from foundry.worlds.camera.language.japanese import JAPANESE
from foundry.worlds.camera.language.words import Act, Dimension, Kind, Table, Word

_OPEN, _CLOSE = '"“„«「『', '"”“»」』'
_SAID = r"said|replied|answered|wrote|responded|chose|was|were|did|executed|tried|attempted|had|to saying"
_SAID_CJK = r"(?:说了?|回答了?|回复了?|选择了|答|写了?|是说)"
_FOLLOWING = (
    r"(?:was|were|did|didn't|had|has|got|led|brought|caused|ended|resulted|failed|worked|moved)\b|->|=>|"
    r"と(?:言|答|指示|返|回答|述|書|いう|して)|という|，?(?:被|但|没|失败|之后|后)"
)
_QUOTED = re.compile(rf"[{_OPEN}]([^{_OPEN}{_CLOSE}\n{{}}]{{1,200}})[{_CLOSE}]")
_BEFORE = re.compile(rf"(?:\b(?:{_SAID})|{_SAID_CJK})[ ,:，：]{{0,3}}\Z", re.IGNORECASE)
_AFTER = re.compile(rf"\s{{0,2}}(?:{_FOLLOWING})", re.IGNORECASE)
_REACH = 24
"""Characters before a quotation in which the word stands that makes it one."""

_ECHO = re.compile(
    r"(?:^|(?<=[.:\n]))[ *-]{0,4}(?:step|ステップ|第) ?\d{1,4}"
    r"[^\n.]{0,200}?(?:\.(?=\d)[^\n.]{0,60}?)?"
    r"(?:->|=>|→)[^\n.]{0,200}",
    re.IGNORECASE | re.MULTILINE,
)
_HEADING = re.compile(
    r"\b(?:options|possible (?:next )?(?:movements|actions|moves|steps|commands)|alternatives|choices|possibilities|"
    r"candidates|history|previous (?:steps|movements|actions|moves|commands)|(?:past|last|recent|earlier) "
    r"(?:steps|movements|actions|moves|commands|decisions)|so far)\b|"
    r"选项|可选|可能的|历史|候选|選択肢|候補|履歴|これまで",
    re.IGNORECASE,
)
_ITEM = re.compile(r"\s*(?:[-*•+–]|\(?(?:\d{1,3}|[a-zA-Z])[.):]|[①-⑳])\s*\S")
_LONGEST_HEADING = 120


def without_quotations(text: str) -> str:
    """Return the text without quotations of earlier steps and without lists of options; linear in its length."""
    if any(mark in text for mark in _CLOSE):
        text = _QUOTED.sub(_kept, text)
    if "->" in text or "=>" in text or "→" in text:
        text = _ECHO.sub(" ", text)
    return _without_lists(text) if "\n" in text else text


def _kept(quoted: re.Match[str]) -> str:
    """Return what is left of a quotation: nothing of a line's start if it is the past."""
    text, start, end = quoted.string, quoted.start(), quoted.end()
    line_starts = not text[max(0, start - _REACH) : start].strip()
    follows = _AFTER.match(text, end)
    if _BEFORE.search(text, max(0, start - _REACH), start) or (follows and not (line_starts and ">" in follows[0])):
        return " "
    return quoted[0]


def _without_lists(text: str) -> str:
    """Drop the lines of lists below a heading such as "Options:"."""
    kept: list[str] = []
    listing = False
    for line in text.split("\n"):
        listing = (listing and (not line.strip() or bool(_ITEM.match(line)))) or _is_heading(line)
        if not listing or not _ITEM.match(line):
            kept.append(line)
    return "\n".join(kept)


def _is_heading(line: str) -> bool:
    bare = line.strip(" *#_`")
    return len(line) <= _LONGEST_HEADING and bare.endswith((":", "：")) and bool(_HEADING.search(bare))


LEXICON: Table = {**CHINESE, **JAPANESE, **ENGLISH}

_CJK = "\u3005\u3007\u3040-\u30ff\u3400-\u9fff"
_LETTER = rf"[^\W\d_{_CJK}]"
_COMMANDING = (Kind.VERB, Kind.WAY, Kind.STAY, Kind.DONE, Kind.PAUSE, Kind.RETRACT)

_FULL_WIDTH = {0xFEE0 + code: code for code in range(0x21, 0x7F)}
_FRACTIONS = {"½": " 1/2", "⅓": " 1/3", "⅔": " 2/3", "¼": " 1/4", "¾": " 3/4", "⅛": " 1/8"}
_PLAIN = str.maketrans(
    {**{chr(wide): chr(code) for wide, code in _FULL_WIDTH.items()}, **_FRACTIONS}
    | dict.fromkeys("’‘ʼ", "'")
    | dict.fromkeys("–—−", "-")
    | dict.fromkeys("º˚", "°")
    | dict.fromkeys("\t\r\v\f\u00a0\u2009\u202f\u3000\u200b\ufeff", " ")
    | {"～": "~", "〜": "~", "⁄": "/", "㍍": "メートル", "…": ".", "。": "。"}
)
_MARKS = str.maketrans(dict.fromkeys('*_`#>"“”„«»「」『』$\\~', " ") | {"|": ","})
_LATEX = re.compile(r"\^?\{?\\(?:circ|degree)\}?")
_LATEX_COMMAND = re.compile(r"\\[a-z]{1,20}")
_TAG = re.compile(r"</?[a-zA-Z][^<>\n]{0,40}>")
_CAMEL = re.compile(r"[A-Z](?<=[a-z].)(?=[a-z])")
_ABBREVIATION = re.compile(
    r"\.(?:(?:(?<=\bdeg.)|(?<=\bft.)|(?<=\bin.)|(?<=\byd.))(?= [a-z])|(?<=\bapprox.)|(?<=\bca.))", re.IGNORECASE
)
_TILDE_RANGE = re.compile(r"~(?:(?<=\d.)|(?<=\d .))")
_SPACED_RANGE = re.compile(r" -(?<=\d..) ?(?=\d)")
_RANGE = re.compile(r"-(?<=\d.) (?=\d)")
_HYPHEN = re.compile(rf"-(?<=\w.)(?={_LETTER})")
_WRAPPED = re.compile(r"\n(?:(?<=,\n)|(?<=[^\n]{60}[a-z]\n)(?=[a-z]))")
_ABOUT = r"(?:by|for|about|around|approximately|roughly)"
_NUMBER_WORDS = "|".join(name for name, word in ENGLISH.items() if word.kind is Kind.NUMBER)
_UNIT = r"(?:m|meters?|metres?|cm|steps?|°|deg|degrees?)"
_AMOUNT_LINE = re.compile(
    rf"(?<=\S)[ \n]{{0,4}}\n *(?=(?:(?:{_ABOUT} ){{1,3}}(?:\d[\d.,/]*|[a-z]{{3,9}})[ °]?[a-z]{{0,12}}"
    rf"|(?:\d[\d.,/]*|{_NUMBER_WORDS}) ?{_UNIT}) *(?:[.,;!\n]|\Z))",
    re.IGNORECASE,
)
_DIRECTION_KEY = re.compile(
    rf"((?:distance|angle) ?[:=] ?\d[\d.]* ?{_UNIT})[,;\n][ \n-]{{0,8}}direction ?[:=] ?", re.IGNORECASE
)
_AMOUNT_KEY = re.compile(
    rf"[,;\n][ \n-]{{0,8}}(?:distance|angle|degrees|amount|magnitude|value) ?[:=] ?(?=(?:{_ABOUT} )?[-+.]?\d)",
    re.IGNORECASE,
)
_AROUND = re.compile(rf"\b(right|go|move) around (?=\d|(?:{_NUMBER_WORDS})\b)", re.IGNORECASE)
_LABEL_LINE = re.compile(r"\b((?:movement|move|action|decision|command|answer) ?:)[ \n]{0,4}\n *", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Token:
    """A word or phrase of the text, and what it means.

    Attributes:
        word: what it means.
        text: as written, in lower case.
        number: value of digits.
        signed: whether digits carry a sign.
    """

    word: Word
    text: str
    number: float = 0.0
    signed: bool = False

    @property
    def kind(self) -> Kind:
        """What it does in the sentence."""
        return self.word.kind


def cleaned(text: str) -> str:
    """Return the text in lower case, its lines unwrapped, without markdown, tags and LaTeX."""
    text = without_quotations(text.translate(_PLAIN))
    if "\\" in text:
        text = _LATEX_COMMAND.sub(" ", _LATEX.sub("°", text))
    if "<" in text:
        text = _TAG.sub("\n", text)
    text = _CAMEL.sub(r" \g<0>", text)
    text = _ABBREVIATION.sub(" ", text.replace("e.g.", "eg ").replace("E.g.", "eg ").replace("i.e.", ", "))
    text = _HYPHEN.sub(" ", _RANGE.sub("-", _SPACED_RANGE.sub("-", _TILDE_RANGE.sub("-", text))))
    text = text.translate(_MARKS)
    while "  " in text:
        text = text.replace("  ", " ")
    if "\n" in text or ":" in text:
        text = _DIRECTION_KEY.sub(r"\1 ", _AMOUNT_KEY.sub(" ", _AMOUNT_LINE.sub(" ", text)))
        text = _LABEL_LINE.sub(r"\1 ", text)
    return _WRAPPED.sub(" ", _AROUND.sub(r"\1 about ", text).replace(" \n", "\n")).lower()


def _alternatives(names: Iterable[str]) -> str:
    """Return an expression for any of the names, the longest first; a Latin one is a whole word."""
    latin: list[str] = []
    other: list[str] = []
    for name in sorted(names):
        (latin if re.fullmatch(_LETTER, name[0]) else other).append(name)
    first = "".join(sorted({name[0] for name in latin}))
    return rf"(?=[{first}])(?<!{_LETTER}){_branches(latin)}(?!{_LETTER})|{_branches(other)}"


def _branches(names: Sequence[str]) -> str:
    """Return an expression for sorted names that shares their beginnings, so that few are tried at each place."""
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
    rf"(?P<digits>{_NUMBER})|(?P<known>{_alternatives(LEXICON)})|(?P<unknown>{_LETTER}+|[{_CJK}])"
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


def command_words(text: str) -> Iterable[re.Match[str]]:
    """Return the places of a cleaned text where a movement may be named."""
    return _COMMAND.finditer(text)


def tokens(text: str) -> list[Token]:
    """Return the tokens of a cleaned text; what is neither word, number nor mark is left out."""
    return [_token(match) for match in _TOKEN.finditer(text)]


def _token(match: re.Match[str]) -> Token:
    text = match[0]
    if match.lastgroup == "known":
        return Token(LEXICON[text], text)
    if match.lastgroup == "digits":
        value = _value(text.lstrip("+-"))
        signed = text[0] in "+-"
        return (
            Token(_UNKNOWN, text)
            if value is None
            else Token(_DIGITS, text, -value if text[0] == "-" else value, signed)
        )
    if text.endswith("ly") and len(text) > _SHORTEST_ADVERB:
        return Token(_ADVERB, text)
    return Token(_SIGNS[match.lastgroup or "unknown"], text)


def _value(digits: str) -> float | None:
    """Return the value of a number with a decimal point or comma, thousands commas, a fraction bar or pi."""
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
