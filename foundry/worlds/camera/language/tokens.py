"""From text to tokens: the tables of all languages in one expression."""

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
from foundry.worlds.camera.language.quotations import without_quotations
from foundry.worlds.camera.language.words import Act, Dimension, Kind, Table, Word

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
