"""The words that foundry understands in replies, from one file per language.

Each entry of a file states a meaning, with the fields of `Word`. In four more fields, the entry lists the phrases that
have this meaning, in lower case:

words       phrases, separated by ` | ` or a line break; `{a|b}` stands for a or b.
inflection  name of a table in `inflections` with the endings that these words can have.
forms       verbs, one per line, each with its forms in the order of `Form`.
numbers     number words with their values, such as `one=1 two=2`.
"""

import re
from collections.abc import Iterator, Mapping
from enum import StrEnum, auto
from itertools import product
from pathlib import Path
from typing import TypeAlias

import msgspec


class Kind(StrEnum):
    """The role that a word has in a sentence."""

    VERB = auto()  # asks for a motion; see Act
    WAY = auto()  # names a direction
    DIGITS = auto()
    NUMBER = auto()  # a number in words
    ARTICLE = auto()  # "a": means one if a unit follows
    POINT = auto()  # the decimal point in words
    UNIT = auto()
    AMOUNT = auto()  # a number with or without its unit, merged from the four above
    BY = auto()  # introduces an amount
    SMALL = auto()  # "a bit"
    STAY = auto()
    DONE = auto()  # "task completed": asks to stay if the reply asks for no motion
    PAUSE = auto()  # "wait", "stop": asks to stay only if nothing follows
    PLACE = auto()  # place of staying: "here"
    NOT = auto()
    POSSIBLE = auto()  # "could": no decision follows
    CONDITION = auto()  # "if": no decision up to the next comma
    EXAMPLE = auto()  # no decision up to the end of the sentence
    FRESH = auto()  # "I will": ends the reach of an earlier "not"
    SEE = auto()  # perception verbs, which an earlier "not" negates instead of a motion
    IS = auto()  # joins a subject and a predicate
    JOIN = auto()  # "and", "then", "so"
    OR = auto()
    BREAK = auto()  # a comma or another mark inside a sentence
    GAZE = auto()  # object of a turn of the gaze: "gaze", "camera"
    FILLER = auto()  # without meaning for the command
    TO = auto()
    OF = auto()
    AT = auto()  # introduces the angle of a translation
    CLOSE = auto()  # begins another phrase: the following words do not belong to the verb
    EARLIER = auto()  # "in the last step": a report, no command
    PAST = auto()  # "tried to", "ました": puts the words in its reach into the past
    AFTER = auto()  # "after" and a motion
    NOW = auto()  # ends a report of earlier or later steps
    LATER = auto()  # "later": postpones its motion
    NEXT = auto()  # "in the next step": postpones only if the reply names an earlier motion
    FIRST = auto()  # "but first": postpones the sentence so far
    RETRACT = auto()  # "no, wait": revokes the reply so far
    OTHER = auto()  # somebody else: "the robot"
    GOAL = auto()  # "task", "goal": its predicate is no command
    PURPOSE = auto()  # "in order to": no command up to the next comma
    OPTION = auto()  # "option A"
    UNKNOWN = auto()


class Act(StrEnum):
    """The kind of motion that a verb asks for."""

    MOVE = auto()
    TURN = auto()
    LOOK = auto()
    MAKE = auto()  # "take", "make": the following words say which motion


class Form(StrEnum):
    """The grammatical form of a verb. Only the forms that change the meaning of a sentence are distinguished."""

    PLAIN = auto()
    ING = auto()
    PAST = auto()
    THIRD = auto()  # "turns": usually about a thing


class Side(StrEnum):
    """The side of a verb on which the direction and amount of the motion stand."""

    AFTER = auto()
    BEFORE = auto()
    BOTH = auto()  # direction before it, amount after it


class Way(StrEnum):
    """A direction."""

    FORWARD = auto()
    BACK = auto()
    LEFT = auto()
    RIGHT = auto()
    UP = auto()
    DOWN = auto()
    AROUND = auto()


class Dimension(StrEnum):
    """The quantity that a unit measures; lengths are converted to metres, angles to degrees."""

    LENGTH = auto()
    ANGLE = auto()
    STEP = auto()  # a configured length
    OTHER = auto()  # no amount of motion


class Word(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The meaning of a word or phrase, such as "a turn" or "to the left".

    Attributes:
        kind: role in a sentence.
        act: the motion that a verb asks for.
        form: form of a verb.
        side: where the direction and the amount of a verb stand.
        ways: the directions that a word names or a verb implies; two make a diagonal.
        goes: whether a verb with a distance alone means forward, as in "walk 2 m".
        number: value of a number, factor of a unit, or degrees that a verb implies; else 0.
        scale: whether a number multiplies the one before it, as "hundred" does, or other agents are several.
        dimension: quantity of a unit.
        reach: where the words are that a word applies to. `after` is the default. With `before`, a negation or
            possibility applies to the verb before it, and a word for the past to the sentence so far. With `both`, a
            word for another agent also applies to words after commas.
        negated: whether the form of a verb includes "not".
        decides: whether a negation is a decision not to move ("will not", unlike "cannot").
    """

    kind: Kind
    act: Act | None = None
    form: Form = Form.PLAIN
    side: Side = Side.AFTER
    ways: tuple[Way, ...] = ()
    goes: bool = False
    number: float = 0.0
    scale: bool = False
    dimension: Dimension | None = None
    reach: str = "after"
    negated: bool = False
    decides: bool = False


class _Meaning(Word, frozen=True, kw_only=True):
    words: str = ""
    inflection: str = ""
    forms: str = ""
    numbers: str = ""


class _Inflection(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The endings that a group of verbs can have, by the verb form that they make.

    Attributes:
        asking: endings that keep the verb's meaning.
        past: endings that put a verb into the past.
        other: endings with which a verb asks for no motion.
        plain: the ending that comes before the words of `_Language.afterwards`.
    """

    asking: tuple[str, ...] = ("",)
    past: tuple[str, ...] = ()
    other: tuple[str, ...] = ()
    plain: str = ""


class _Language(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The content of a language's file. A verb before one of the words `afterwards` asks for no motion."""

    meanings: list[_Meaning]
    inflections: dict[str, _Inflection] = {}
    afterwards: tuple[str, ...] = ()

    def phrases(self, meaning: _Meaning) -> Iterator[tuple[str, Word]]:
        word = msgspec.convert(meaning, Word, from_attributes=True)
        past, unknown = msgspec.structs.replace(word, form=Form.PAST), Word(Kind.UNKNOWN)
        for line in meaning.forms.splitlines():
            verbs = zip(line.split(" | "), Form, strict=False)
            yield from ((verb, msgspec.structs.replace(word, form=form)) for verb, form in verbs)
        for name, value in (pair.split("=") for pair in meaning.numbers.split()):
            yield name, msgspec.structs.replace(word, number=float(value))
        stems = list(_expanded(meaning.words))
        endings = self.inflections[meaning.inflection] if meaning.inflection else _Inflection()
        other = (*endings.other, *(endings.plain + after for after in self.afterwards if endings.plain))
        for chosen, inflected in ((other, unknown), (endings.asking, word), (endings.past, past)):
            yield from ((stem + ending, inflected) for stem in stems for ending in chosen)


def _expanded(words: str) -> Iterator[str]:
    for phrase in filter(None, re.split(r" \| |\n", words)):
        parts = (part.split("|") for part in re.split(r"[{}]", phrase))
        yield from (" ".join("".join(choice).split()) for choice in product(*parts))


Table: TypeAlias = Mapping[str, Word]
"""The meaning of each phrase; phrases are in lower case, with one blank between words."""


def read_language(name: str) -> Table:
    """Return the meaning of each phrase of a language. If the file lists a phrase twice, its last meaning counts."""
    content = Path(__file__).with_name(f"{name}.toml").read_bytes()
    language = msgspec.toml.decode(content, type=_Language)
    return {phrase: word for meaning in language.meanings for phrase, word in language.phrases(meaning)}


ENGLISH = read_language("english")
LEXICON: Table = {**read_language("chinese"), **read_language("japanese"), **ENGLISH}
