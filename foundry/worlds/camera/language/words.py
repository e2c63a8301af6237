"""The kinds of word that matter to the reading of a movement; the tables of each language are made of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto
from typing import TypeAlias


class Kind(Enum):
    """What a word does in a sentence."""

    VERB = auto()  # asks for a motion; see Act
    WAY = auto()  # names a direction
    DIGITS = auto()
    NUMBER = auto()  # a number in words
    ARTICLE = auto()  # "a": one, when a unit follows
    POINT = auto()  # the decimal point in words
    UNIT = auto()
    AMOUNT = auto()  # a number with or without its unit; made of the four above
    BY = auto()  # introduces an amount
    SMALL = auto()  # "a bit"
    STAY = auto()
    DONE = auto()  # "task completed": asks to stay where the reply asks for no motion
    PAUSE = auto()  # asks to stay only when nothing follows: "wait", "stop"
    PLACE = auto()  # says where to stay: "here"
    NOT = auto()
    POSSIBLE = auto()  # "could": what follows is no decision
    CONDITION = auto()  # "if": no decision either, up to the next comma
    EXAMPLE = auto()  # no decision either, up to the end of the sentence
    FRESH = auto()  # "I will": ends what an earlier "not" reaches
    SEE = auto()  # what a "not" before it is about
    IS = auto()  # joins a subject to what is said about it
    JOIN = auto()  # "and", "then", "so"
    OR = auto()
    BREAK = auto()  # a comma or another mark inside a sentence
    GAZE = auto()  # what is turned when one looks elsewhere: "gaze", "camera"
    FILLER = auto()  # changes nothing
    TO = auto()
    OF = auto()
    AT = auto()  # introduces the angle of a translation
    CLOSE = auto()  # starts something else: what follows no longer belongs to the verb
    EARLIER = auto()  # "in the last step": what is told of it is no command
    PAST = auto()  # "tried to", "ました": puts what it reaches into the past
    AFTER = auto()  # "after" and a motion
    NOW = auto()  # ends what is told of earlier or later steps
    LATER = auto()  # "later": what it is said of is put off
    NEXT = auto()  # "in the next step": put off only where the reply says what comes before
    FIRST = auto()  # "but first": what the sentence said before is put off
    RETRACT = auto()  # "no, wait": what the reply said before is taken back
    OTHER = auto()  # somebody else: "the robot"
    GOAL = auto()  # "task", "goal": what it is, is no command
    PURPOSE = auto()  # "in order to": no command, up to the next comma
    OPTION = auto()  # "option A"
    UNKNOWN = auto()


class Act(Enum):
    """What a verb asks for."""

    MOVE = auto()
    TURN = auto()
    LOOK = auto()
    MAKE = auto()  # "take", "make": what it asks for is said by the words after it


class Form(Enum):
    """The form of a verb, as far as it changes the reading."""

    PLAIN = auto()
    ING = auto()
    PAST = auto()
    THIRD = auto()  # "turns": usually said of a thing


class Side(Enum):
    """Where the words stand that belong to a verb."""

    AFTER = auto()
    BEFORE = auto()
    BOTH = auto()  # direction before it, amount after it


class Way(Enum):
    """A direction."""

    FORWARD = "forward"
    BACK = "back"
    LEFT = "left"
    RIGHT = "right"
    UP = "up"
    DOWN = "down"
    AROUND = "around"


class Dimension(Enum):
    """What a unit measures; the factors lead to metres and degrees."""

    LENGTH = auto()
    ANGLE = auto()
    STEP = auto()  # a length that is configured
    OTHER = auto()  # no amount of motion


@dataclass(frozen=True, slots=True)
class Word:
    """What a word or phrase means.

    Attributes:
        kind: what it does in a sentence.
        act: of a verb: what it asks for.
        form: of a verb.
        side: of a verb: where its direction and amount stand.
        ways: the directions it names or, for a verb, implies; two make a diagonal.
        goes: of a verb: whether a distance alone makes it go forward: "walk 2 m".
        number: value of a number, factor of a unit; of a verb the degrees it implies, or 0.
        scale: the number multiplies the one before it: "hundred"; of somebody else: there are several.
        dimension: of a unit.
        reach: of a negation or possibility: `after` or `before` (the verb before it); of the past: `before` (all
            of the sentence before it); of somebody else: `both` (over commas too).
        negated: of a verb: whether its form says "not".
        decides: of a negation: whether not moving is what it decides ("will not", unlike "cannot").
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


Table: TypeAlias = Mapping[str, Word]
"""Phrases, in lower case with single blanks, and what they mean."""


def phrases(word: Word, text: str) -> dict[str, Word]:
    """Return a table that gives each of the phrases, which `|` separates, the same meaning."""
    return {phrase.strip(): word for phrase in text.split("|")}


def numbers(text: str, *, scale: bool = False) -> dict[str, Word]:
    """Return a table of number words from "one=1 two=2"."""
    pairs = (pair.split("=") for pair in text.split())
    return {name: Word(Kind.NUMBER, number=float(value), scale=scale) for name, value in pairs}
