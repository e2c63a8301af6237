"""From the words that belong to a verb to the motion they ask for."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from enum import Enum

from foundry.worlds.camera.language.amounts import Amount
from foundry.worlds.camera.language.command import BEARINGS
from foundry.worlds.camera.language.words import Act, Dimension, Kind, Way, Word


class Category(Enum):
    """What a movement consists of; each is decided by its latest occurrence."""

    TRANSLATE = "translate"
    TURN = "turn"
    GAZE = "gaze"
    STAY = "stay"
    RETRACT = "retract"  # no motion: what follows replaces what was said before
    ORDER = "order"  # no motion: what follows is the answer, and replaces a plan before it


@dataclass(frozen=True, slots=True)
class Mention:
    """One motion that a sentence names.

    Attributes:
        category: what kind of motion.
        direction: bearing of a translation, degrees from the heading, counter-clockwise; else +1 for left or up, -1
            for right or down, 0 where none is named (of a motion that is not wanted).
        amount: how far, None when the text does not say.
        small: "a bit".
        degrees: degrees that the words imply, 0 when they imply none.
        text: the words it was read from.
        wanted: False for what the text says not to do.
        told: whether the text only tells of it; then it is not wanted either.
        inferred: whether more than the amount had to be supplied.
        later: whether it is put off, should the reply name anything else.
        remarks: what had to be decided to read it.
    """

    category: Category
    direction: float = 0.0
    amount: Amount | None = None
    small: bool = False
    degrees: float = 0.0
    text: str = ""
    wanted: bool = True
    told: bool = False
    inferred: bool = False
    later: bool = False
    remarks: tuple[str, ...] = ()


@dataclass(slots=True)
class Arguments:
    """The words that belong to a verb, or stand without one.

    Attributes:
        ways: the directions.
        amount: how far.
        small: "a bit".
        gaze: whether the gaze is named as what is turned.
        angle: the angle of a translation: "at 30 degrees to the left".
        closed: whether further words follow that say something else.
        along: whether these say what to move along or towards.
        start: index of the first of them, or of the verb.
        end: index of the first token behind them.
        last: index behind the last token that says something.
        inferred: whether more than the amount had to be supplied.
        remarks: what had to be decided.
    """

    ways: list[Way] = field(default_factory=list)
    amount: Amount | None = None
    small: bool = False
    gaze: bool = False
    angle: Amount | None = None
    closed: bool = False
    along: bool = False
    start: int = 0
    end: int = 0
    last: int = 0
    inferred: bool = False
    remarks: list[str] = field(default_factory=list)

    def infer(self, remark: str) -> None:
        """Note that the reading takes more than the words say."""
        self.inferred = True
        self.remarks.append(remark)


_SIDES = {Way.LEFT: 1.0, Way.RIGHT: -1.0}
_VERTICAL = {Way.UP: 1.0, Way.DOWN: -1.0}
_HALF_TURN = 180.0
_BARE = {act: Word(Kind.VERB, act=act, goes=True) for act in Act}
_TURNS = frozenset(("half", "quarter", "quarters", "full"))


def mention(verb: Word, said: Arguments) -> Mention | str:
    """Return the motion that a verb and its words ask for, or why they ask for none."""
    if said.amount is not None and said.amount.dimension is Dimension.OTHER:
        said.remarks.append(f"'{said.amount.text}' is no distance and no angle")
        said.amount = None
    implied = () if said.ways and Way.FORWARD in verb.ways else verb.ways
    ways = {*said.ways, *implied} - {Way.AROUND}
    angular = said.amount is not None and said.amount.dimension is Dimension.ANGLE
    if ways & _VERTICAL.keys() or (verb.act is Act.LOOK and not ways):
        return _gaze(verb, said, ways, angular=angular)
    if verb.act is Act.MOVE and not angular and not said.gaze:
        if _goes_forward(verb, said, ways):
            said.infer("no direction named: read as forward")
            ways = {Way.FORWARD}
        return _translation(said, ways)
    if verb.act is Act.LOOK and not ways & _SIDES.keys():
        return "a gaze that is neither up nor down"
    if verb.act is Act.MOVE and angular:
        said.infer("an angle: read as a turn")
    elif verb.act is not Act.TURN:
        said.infer("the gaze has no side of its own: read as a turn")
    return _turn(verb, said, ways)


def made(said: Arguments) -> Word:
    """Return the verb that "take" or "make" stands for: "take a step back", "take a left"."""
    angular = said.amount is not None and said.amount.dimension is Dimension.ANGLE
    along = said.amount is not None or not said.ways or {Way.FORWARD, Way.BACK} & {*said.ways}
    return _BARE[Act.MOVE if along and not angular else Act.TURN]


def bare_mention(said: Arguments, act: Act | None, *, shared: bool = False) -> Mention | str:
    """Return the motion that words without a verb ask for.

    Args:
        said: the words.
        act: what the verb before them asks for, or None.
        shared: whether they belong to that verb for certain: "turn: left".
    """
    dimension = said.amount.dimension if said.amount else None
    vertical = bool(said.ways) and {*said.ways} <= _VERTICAL.keys()
    if dimension is Dimension.ANGLE:
        return mention(_BARE[Act.LOOK if vertical else Act.TURN], said)
    if said.gaze and vertical:
        return mention(_BARE[Act.LOOK], said)
    if dimension in (Dimension.LENGTH, Dimension.STEP) or {Way.FORWARD, Way.BACK} & {*said.ways}:
        return mention(_BARE[Act.MOVE], said)
    if (shared or said.amount is not None) and act is not None and act is not Act.MAKE:
        return mention(_BARE[act], said)
    return "a direction without a verb"


def _gaze(verb: Word, said: Arguments, ways: Collection[Way], *, angular: bool) -> Mention | str:
    if verb.act is Act.MOVE and not said.gaze and not angular:
        return "there is no vertical translation"
    if verb.act is Act.LOOK and verb.ways and not said.gaze and not angular:
        return "nothing says that the gaze is meant"
    vertical = [_VERTICAL[way] for way in ways if way in _VERTICAL]
    if len(vertical) == 1 and not {*ways} & _SIDES.keys():
        return _angular(Category.GAZE, vertical[0], said)
    if ways or said.amount is None or not said.amount.signed:
        return "a gaze that is neither up nor down"
    sign = -1.0 if said.amount.number < 0 else 1.0
    return _angular(Category.GAZE, sign, said, signed=True)


def _goes_forward(verb: Word, said: Arguments, ways: Collection[Way]) -> bool:
    """Tell whether a distance is named without a direction: "walk 2 m", "walk along the corridor for 2 m"."""
    if ways or said.angle is not None or said.amount is None or not (said.along or (verb.goes and not said.closed)):
        return False
    return said.amount.dimension in (Dimension.LENGTH, Dimension.STEP)


def _translation(said: Arguments, ways: Collection[Way]) -> Mention | str:
    bearing = BEARINGS.get(frozenset(ways))
    if said.angle is not None:
        if len(said.ways) != 1 or said.ways[0] not in _SIDES:
            return "an angle without a side"
        bearing = normalised(_SIDES[said.ways[0]] * said.angle.number)
    if bearing is None:
        return "a translation in contrary directions" if ways else "a translation without a direction"
    if said.amount is not None and said.amount.number < 0:
        return "a negative distance"
    return Mention(
        Category.TRANSLATE, bearing, said.amount, said.small, inferred=said.inferred, remarks=tuple(said.remarks)
    )


def _turn(verb: Word, said: Arguments, ways: Collection[Way]) -> Mention | str:
    sides = [_SIDES[way] for way in ways if way in _SIDES]
    if len(sides) > 1 or len(sides) < len(ways):
        return "a turn in contrary directions"
    degrees = verb.number
    if said.amount is not None and said.amount.dimension is None and _TURNS & {*said.amount.text.split()}:
        degrees, said.amount = 2 * _HALF_TURN * said.amount.number, None
    asked = said.amount.number if said.amount is not None else degrees
    if sides:
        return _angular(Category.TURN, sides[0], said, degrees=degrees)
    if asked == _HALF_TURN:
        said.remarks.append("half a turn: either side leads there")
        return _angular(Category.TURN, 1.0, said, degrees=degrees)
    return "a turn without a side"


def _angular(
    category: Category, sign: float, said: Arguments, *, degrees: float = 0.0, signed: bool = False
) -> Mention | str:
    if said.amount is not None and said.amount.number < 0 and not signed:
        return "a negative angle"
    return Mention(
        category, sign, said.amount, said.small, degrees, inferred=said.inferred, remarks=tuple(said.remarks)
    )


def normalised(degrees: float) -> float:
    """Return an angle in (-180, 180]."""
    if -_HALF_TURN < degrees <= _HALF_TURN:
        return degrees
    turned = degrees % 360.0
    return turned - 360.0 if turned > _HALF_TURN else turned
