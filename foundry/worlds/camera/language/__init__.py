"""Commands as data, in words and in records, and the kinds of word that determine their reading.

`interpreter` reads replies with a table of such words per language.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import Enum, auto
from typing import Any, TypeAlias

import numpy as np

from foundry.errors import InputError
from foundry.records import CameraStep, Outcome, command_kind


class Kind(Enum):
    """The role of a word in a sentence."""

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


class Act(Enum):
    """The motion that a verb asks for."""

    MOVE = auto()
    TURN = auto()
    LOOK = auto()
    MAKE = auto()  # "take", "make": the following words say which motion


class Form(Enum):
    """The form of a verb, as far as it affects the reading."""

    PLAIN = auto()
    ING = auto()
    PAST = auto()
    THIRD = auto()  # "turns": usually about a thing


class Side(Enum):
    """The place of the words that belong to a verb."""

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
    """The quantity of a unit; the factors convert to metres and degrees."""

    LENGTH = auto()
    ANGLE = auto()
    STEP = auto()  # a configured length
    OTHER = auto()  # no amount of motion


@dataclass(frozen=True, slots=True)
class Word:
    """The meaning of a word or phrase.

    Attributes:
        kind: role in a sentence.
        act: for a verb, the motion that it asks for.
        form: for a verb, its form.
        side: for a verb, the place of its direction and amount.
        ways: the directions that it names or, for a verb, implies; two make a diagonal.
        goes: for a verb, whether a distance alone means forward: "walk 2 m".
        number: value of a number, factor of a unit, or degrees that a verb implies, else 0.
        scale: whether the number multiplies the one before it ("hundred"), or the other agents are several.
        dimension: for a unit, its quantity.
        reach: for a negation or possibility, `after` or `before` (the verb before it); for the past, `before` (the
            sentence so far); for another agent, `both` (across commas too).
        negated: for a verb, whether its form includes "not".
        decides: for a negation, whether it is a decision not to move ("will not", unlike "cannot").
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
"""Meanings of phrases, which are in lower case with single blanks."""


def phrases(texts: Mapping[Word, str]) -> dict[str, Word]:
    """Return a table of phrases from the text of each meaning; `|` separates phrases."""
    return {phrase.strip(): word for word, text in texts.items() for phrase in text.split("|")}


def numbers(text: str, *, scale: bool = False) -> dict[str, Word]:
    """Return a table of number words from a text such as "one=1 two=2"."""
    pairs = (pair.split("=") for pair in text.split())
    return {name: Word(Kind.NUMBER, number=float(value), scale=scale) for name, value in pairs}


BEARINGS = {
    frozenset((Way.FORWARD,)): 0.0,
    frozenset((Way.FORWARD, Way.LEFT)): 45.0,
    frozenset((Way.LEFT,)): 90.0,
    frozenset((Way.BACK, Way.LEFT)): 135.0,
    frozenset((Way.BACK,)): 180.0,
    frozenset((Way.BACK, Way.RIGHT)): -135.0,
    frozenset((Way.RIGHT,)): -90.0,
    frozenset((Way.FORWARD, Way.RIGHT)): -45.0,
}
"""Bearings by their directions; degrees from the heading, counter-clockwise."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Default amounts, and the largest amounts of a command.

    Attributes:
        max_distance_m: longest translation; None for no limit.
        max_turn_deg: largest turn of the body to either side; None for no limit.
        max_gaze_deg: largest turn of the gaze up or down; None for no limit.
        default_distance_m: length of a translation without a distance.
        default_turn_deg: angle of a turn without an angle.
        default_gaze_deg: angle of a turn of the gaze without an angle.
        small_factor: factor of "a bit" on the default.
        step_length_m: length of a step.
    """

    max_distance_m: float | None = None
    max_turn_deg: float | None = None
    max_gaze_deg: float | None = None
    default_distance_m: float = 1.0
    default_turn_deg: float = 30.0
    default_gaze_deg: float = 15.0
    small_factor: float = 0.5
    step_length_m: float = 0.7

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None and not 0 < value < float("inf"):
                raise InputError(f"limits.{field.name} is {value}. Give a number above 0.")


@dataclass(frozen=True)
class Translation:
    """A translation of the body.

    Attributes:
        bearing: degrees from the heading, counter-clockwise: 0 forward, 90 left, 180 back, -90 right.
        distance: metres.
    """

    bearing: float
    distance: float


@dataclass(frozen=True)
class Command:
    """The command in a reply; None for parts that it does not ask for.

    Attributes:
        translate: translation of the body.
        turn: turn of the body, degrees, left positive.
        gaze: turn of the gaze, degrees, up positive.
        stay: whether it asks to stay, without any motion.
        outcome: `chosen`, `repaired` or `unreadable`.
        notes: remarks on the reading, one line each.
    """

    translate: Translation | None = None
    turn: float | None = None
    gaze: float | None = None
    stay: bool = False
    outcome: Outcome = Outcome.UNREADABLE
    notes: tuple[str, ...] = ()

    @property
    def idle(self) -> bool:
        """True if it moves nothing: "stay", an unreadable reply, or amounts of zero."""
        return not (self.turn or self.gaze or (self.translate is not None and self.translate.distance))

    @property
    def is_read(self) -> bool:
        """True if the reply contains a command."""
        return self.outcome in (Outcome.CHOSEN, Outcome.REPAIRED)

    @property
    def kind(self) -> str:
        """Its kind, one of `foundry.records.COMMAND_KINDS`."""
        way = self.translate or Translation(0.0, 0.0)
        return command_kind(way.bearing, way.distance, self.turn or 0.0, self.gaze or 0.0)


def every_kind(limits: Limits) -> tuple[Command, ...]:
    """Return a command of each kind that moves, with default amounts within the limits.

    They are in the order of `foundry.records.COMMAND_KINDS`, whose first kind does not move.
    """
    metres = min(limits.default_distance_m, limits.max_distance_m or math.inf)
    turn = min(limits.default_turn_deg, limits.max_turn_deg or math.inf)
    gaze = min(limits.default_gaze_deg, limits.max_gaze_deg or math.inf)
    ways = (Command(translate=Translation(bearing, metres)) for bearing in (0.0, 180.0, 90.0, -90.0))
    return (*ways, Command(turn=turn), Command(turn=-turn), Command(gaze=gaze), Command(gaze=-gaze))


def render_command(command: Command) -> str:
    """Return a command in words; reading them gives the same motions."""
    parts = []
    if command.translate is not None:
        parts.append(_rendered_translation(command.translate))
    if command.turn is not None:
        parts.append(f"turn {'right' if command.turn < 0 else 'left'} {_number(command.turn)} degrees")
    if command.gaze is not None:
        parts.append(f"look {'down' if command.gaze < 0 else 'up'} {_number(command.gaze)} degrees")
    return ", ".join(parts) or ("stay" if command.stay else "nothing understood")


def _rendered_translation(translation: Translation) -> str:
    distance = f"move {_number(translation.distance)} m"
    for ways, bearing in BEARINGS.items():
        if bearing == translation.bearing:
            return f"{distance} {'-'.join(sorted(way.value for way in ways))}"
    side = "right" if translation.bearing < 0 else "left"
    return f"{distance} at an angle of {_number(translation.bearing)} degrees to the {side}"


def _number(value: float) -> str:
    """Return the shortest digits that give this number again, without sign and exponent."""
    return np.format_float_positional(abs(value), trim="-")


def limited(name: str, asked: float, largest: float | None, unit: str, notes: list[str]) -> float:
    """Return an amount, clamped to its limit on either side; add a note if it was clamped."""
    if largest is None or abs(asked) <= largest:
        return float(asked)
    notes.append(f"{name}: {abs(asked):g} {unit} clamped to {largest:g} {unit}")
    return math.copysign(largest, asked)


def command_record(command: Command) -> dict[str, Any]:
    """Return a command as plain data: `translate` (null or `{bearing, distance}`), `turn`, `gaze`, `stay`."""
    translate = command.translate
    return {
        "translate": None
        if translate is None
        else {"bearing": round(translate.bearing, 9), "distance": round(translate.distance, 9)},
        "turn": command.turn,
        "gaze": command.gaze,
        "stay": command.stay,
    }


def recorded_command(step: CameraStep) -> Command:
    """Return the command of a recorded decision; the inverse of `command_record`."""
    said = step.command
    translate = None if said["translate"] is None else Translation(**said["translate"])
    return Command(translate, said["turn"], said["gaze"], said["stay"], step.outcome, step.notes)


def describe(command: Command, record: CameraStep) -> str:
    """Return a short phrase with the understood command and its result."""
    said = str(record.outcome)
    if record.outcome in (Outcome.CHOSEN, Outcome.REPAIRED):
        said = f"answers {record.command['answer']}" if "answer" in record.command else render_command(command)
    return f"{said}; {record.boundary}" if record.boundary else said
