"""From text to tokens: the tables of all languages in one expression."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass

from foundry.worlds.usd.language.asian import CHINESE, JAPANESE
from foundry.worlds.usd.language.english import ENGLISH
from foundry.worlds.usd.language.european import FRENCH, GERMAN, SPANISH
from foundry.worlds.usd.language.words import Act, Kind, Table, Word

LEXICON: Table = {**FRENCH, **SPANISH, **GERMAN, **CHINESE, **JAPANESE, **ENGLISH}

_CJK = "\u3005\u3007\u3040-\u30ff\u3400-\u9fff"
_LETTER = rf"[^\W\d_{_CJK}]"
_COMMANDING = (Kind.VERB, Kind.WAY, Kind.STAY, Kind.PAUSE)

_FRACTIONS = str.maketrans(
    {sign: f" {unicodedata.normalize('NFKC', sign)}" for sign in "½⅓⅔¼¾⅕⅖⅗⅘⅛⅜⅝⅞"} | {"º": "°", "˚": "°"}
)
_MARKS = str.maketrans(
    dict.fromkeys('*_`#>"“”„«»「」『』$\\~\u200b\ufeff', " ")
    | dict.fromkeys("’‘ʼ", "'")
    | {"⁄": "/", "−": "-", "|": ","}
)
_LATEX = re.compile(r"\^?\s?\{?\\circ\}?|\\degree")
_LATEX_COMMAND = re.compile(r"\\[a-z]{1,20}")
_TAG = re.compile(r"</?[a-zA-Z][^<>\n]{0,40}>")
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z][a-z])")
_ABBREVIATION = re.compile(r"\b(?:(deg|ft|in|yd)\.(?=[ \t]+[a-z])|(approx|ca|e\.g|i\.e)\.(?=[\s,]))", re.IGNORECASE)
_RANGE = re.compile(r"(?<=\d)[ \t]?[~〜–—-][ \t]?(?=\d)")
_HYPHEN = re.compile(rf"(?<=\w)-(?={_LETTER})")
_WRAPPED = re.compile(r"(?<=[^\n]{60})(?<=[a-z])[ \t]?\n(?=[a-z])|(?<=,)[ \t]{0,3}\n")
_BLANKS = re.compile(r"[^\S\n]{2,}|[^\S\n ]")


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
    """Return the text in lower case without markdown, tags and LaTeX, in compatible characters, on unwrapped lines."""
    text = unicodedata.normalize("NFKC", text.translate(_FRACTIONS))
    if "\\" in text:
        text = _LATEX_COMMAND.sub(" ", _LATEX.sub("°", text))
    if "<" in text:
        text = _TAG.sub("\n", text)
    text = _CAMEL.sub(" ", text)
    text = _ABBREVIATION.sub(r"\1\2 ", text)
    text = _RANGE.sub("-", text).translate(_MARKS).lower()
    return _BLANKS.sub(" ", _WRAPPED.sub(" ", _HYPHEN.sub(" ", text)))


def _alternatives(names: Iterable[str]) -> str:
    """Return an expression for any of the names, the longest first; a Latin one must not go on."""
    ordered = sorted(names, key=len, reverse=True)
    latin = [re.escape(name) for name in ordered if re.fullmatch(_LETTER, name[-1])]
    other = [re.escape(name) for name in ordered if not re.fullmatch(_LETTER, name[-1])]
    return rf"{'|'.join(other)}|(?:{'|'.join(latin)})(?!{_LETTER})"


_NUMBER = r"(?:(?<![^\s(:=,])[-+])?(?:\d{1,9} ?/ ?\d{1,9}(?![\d.,/])|\d+(?:[.,]\d+)*|(?<!\d)\.\d+)"
_TOKEN = re.compile(
    rf"(?P<digits>{_NUMBER})|(?P<known>{_alternatives(LEXICON)})|(?P<unknown>{_LETTER}+|[{_CJK}])"
    r"|(?P<or>/)|(?P<range>(?<=\d)-(?=\d))|(?P<mark>->|=>| - |[,:()\[\]{}=—–…、・])"
)
_COMMAND = re.compile(
    rf"(?<!{_LETTER})(?:"
    + _alternatives(name for name, word in LEXICON.items() if word.kind in _COMMANDING and word.act is not Act.MAKE)
    + ")"
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
    """Return the value of a number with a decimal point or comma, thousands commas or a fraction bar."""
    top, bar, bottom = digits.partition("/")
    if bar:
        return float(top) / float(bottom) if float(bottom) else None
    if re.fullmatch(r"[1-9]\d{0,2}(?:,\d{3})+(?:\.\d+)?", digits):
        return float(digits.replace(",", ""))
    return float(digits.replace(",", ".")) if len(re.findall(r"[.,]", digits)) < 2 else None
