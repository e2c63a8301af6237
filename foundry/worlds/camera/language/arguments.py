"""Collects the words that belong to a verb, and converts them to the motion that it asks for."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from enum import Enum

from foundry.worlds.camera.language import BEARINGS
from foundry.worlds.camera.language.lexicon import Act, Dimension, Kind, Side, Way, Word
from foundry.worlds.camera.language.sentences import Amount, Token


class Category(Enum):
    """A kind of motion; if a reply names a kind several times, its last mention counts."""

    TRANSLATE = "translate"
    TURN = "turn"
    GAZE = "gaze"
    STAY = "stay"
    RETRACT = "retract"  # no motion: the following text replaces the text before it
    ORDER = "order"  # no motion: the following text is the answer, and replaces a plan before it


@dataclass(frozen=True, slots=True)
class Mention:
    """A motion in a sentence.

    Attributes:
        category: kind of motion.
        direction: bearing of a translation, degrees from the heading, counter-clockwise; else +1 for left or up, -1 for
            right or down, 0 for a refused motion without a direction.
        amount: the stated amount, None if the text has none.
        small: whether the text says "a bit".
        degrees: angle that the words imply, as in "turn around", degrees; else 0.
        wanted: False for a motion that the text refuses.
        told: whether the text only reports the motion; then `wanted` is False too.
        inferred: whether anything but the amount had to be inferred.
        later: whether the motion counts only if the reply names no earlier motion.
        remarks: notes on how the text was read.
        segment: index of the segment of the sentence that names the motion.
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
    segment: int = 0


@dataclass(slots=True)
class Arguments:
    """The words that state the direction and amount of a motion, with or without a verb.

    Attributes:
        small: whether the words say "a bit".
        gaze: whether the words name the gaze.
        angle: angle of a translation, as in "at 30 degrees to the left".
        closed: whether words that do not belong to the verb follow.
        along: whether those words name a path or a goal, as in "along the corridor".
        start: index of the first of the words, or of the verb.
        end: index after the words.
        last: index after the last direction, amount or similar word.
        inferred: whether anything but the amount had to be inferred.
        remarks: notes on how the text was read.
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
        """Record that a part of the motion was inferred, since the words do not state it."""
        self.inferred = True
        self.remarks.append(remark)


_SIDES = {Way.LEFT: 1.0, Way.RIGHT: -1.0}
_VERTICAL = {Way.UP: 1.0, Way.DOWN: -1.0}
_HALF_TURN = 180.0
_BARE = {act: Word(Kind.VERB, act=act, goes=True) for act in Act}
_TURNS = frozenset(("half", "quarter", "quarters", "full"))


def mention(verb: Word, said: Arguments) -> Mention | str:
    """Return the motion that a verb and its words ask for, or the reason why there is no motion."""
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
    """Return the verb that "take" or "make" stands for: to move in "take a step back", to turn in "take a left"."""
    angular = said.amount is not None and said.amount.dimension is Dimension.ANGLE
    along = said.amount is not None or not said.ways or {Way.FORWARD, Way.BACK} & {*said.ways}
    return _BARE[Act.MOVE if along and not angular else Act.TURN]


def bare_mention(said: Arguments, act: Act | None, *, shared: bool = False) -> Mention | str:
    """Return the motion that words without a verb ask for; if they ask for none, return the reason as text.

    `act` is the kind of motion of the verb before them; with `shared`, it applies to them, as in "turn: left".
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
    """Return whether a distance without a direction means forward, as in "walk 2 m"."""
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
    """Return the same angle within (-180, 180], degrees."""
    if -_HALF_TURN < degrees <= _HALF_TURN:
        return degrees
    turned = degrees % 360.0
    return turned - 360.0 if turned > _HALF_TURN else turned


HARMLESS = frozenset(
    (
        *(Kind.FILLER, Kind.TO, Kind.OF, Kind.BY, Kind.ARTICLE, Kind.PLACE, Kind.FRESH, Kind.SMALL, Kind.GAZE, Kind.IS),
        *(Kind.EARLIER, Kind.NOW, Kind.LATER, Kind.NEXT, Kind.FIRST, Kind.RETRACT),
    )
)
"""Kinds of word that do not change a command."""

ARGUMENTS = frozenset((Kind.WAY, Kind.AMOUNT, Kind.SMALL, Kind.GAZE, Kind.AT))

_PASSED = HARMLESS - {Kind.IS, Kind.SMALL, Kind.GAZE}
_STOPS = frozenset((Kind.VERB, Kind.NOT, Kind.CONDITION, Kind.POSSIBLE, Kind.STAY, Kind.PAUSE))
_ELSEWHERE = frozenset(
    ("away", "tall", "wide", "high", "long", "deep", "thick", "apart", "short", "in front", "ahead of")
)
_NAMES = (Kind.UNKNOWN, Kind.OTHER, Kind.GOAL)
_HERE = frozenset(("here", "my", "your", "current", "this"))
_PATHS = frozenset(
    ("toward", "towards", "along", "through", "down the", "up the", "closer", "across", "into")
    + ("に向かって", "へ向かって", "に沿って", "向かって", "の方へ", "に近づくために", "に近づくため")
)
_ATTRIBUTED = frozenset(("side", "hand side", "hand"))
_MEASURED = frozenset(("step", "move"))
"""Words that are verbs of motion, but nouns after an amount: "step" in "a 2 m step forward"."""


def words_after(tokens: Sequence[Token], start: int, verb: Token | None) -> Arguments:
    """Return the words from `start` on that belong to a verb; if `verb` is None, all words up to the next verb."""
    said = Arguments(start=start - 1 if verb else start, end=start, last=start)
    for at in range(start, len(tokens)):
        kind = tokens[at].kind
        if kind in _STOPS or _starts_another(tokens, at, said, verb):
            break
        ends = said.along and at + 1 == len(tokens) and _is_length(tokens[at])
        if not said.closed or (kind is Kind.AMOUNT and (tokens[at - 1].kind is Kind.BY or ends)):
            was_closed = said.closed
            _take(tokens, at, said)
            said.along = said.along or (said.closed and not was_closed and tokens[at].text in _PATHS)
        elif kind is Kind.CLOSE and tokens[at].text not in _PATHS:
            said.along = False
        said.end = at + 1
    return said


def _is_length(token: Token) -> bool:
    return isinstance(token, Amount) and token.dimension in (Dimension.LENGTH, Dimension.STEP)


def words_before(tokens: Sequence[Token], low: int, verb_at: int) -> Arguments:
    """Return the words right before a verb that belong to the verb; no word before index `low` belongs to it."""
    start = verb_at
    while start > low and (tokens[start - 1].kind in ARGUMENTS or tokens[start - 1].kind in HARMLESS):
        start -= 1
    said = Arguments(start=start, end=verb_at + 1, last=verb_at + 1)
    for at in range(start, verb_at):
        if tokens[at].kind is Kind.AMOUNT and said.amount is not None:
            continue
        _take(tokens, at, said, checked=False)
    said.closed = start > low
    said.along = said.closed and tokens[start - 1].text in _PATHS
    return said


def words_around(tokens: Sequence[Token], low: int, verb_at: int) -> Arguments:
    """Return the words that belong to a verb: directions before or right after the verb, and amounts after the verb."""
    before = words_before(tokens, low, verb_at)
    said = Arguments(
        before.ways, before.amount, before.small, before.gaze, start=before.start, end=verb_at + 1, last=verb_at + 1
    )
    for at in range(verb_at + 1, len(tokens)):
        kind = tokens[at].kind
        if kind is Kind.AMOUNT and said.amount is not None or (kind is Kind.WAY and (said.ways or at > verb_at + 1)):
            break
        if kind not in HARMLESS and kind not in ARGUMENTS:
            break
        _take(tokens, at, said, checked=False)
        said.end = at + 1
    return said


def collect(tokens: Sequence[Token], low: int, verb_at: int) -> Arguments:
    """Return the words that belong to the verb at index `verb_at`; no word before index `low` belongs to it."""
    verb = tokens[verb_at]
    if verb.word.side is Side.BEFORE:
        return words_before(tokens, low, verb_at)
    if verb.word.side is Side.BOTH:
        return words_around(tokens, low, verb_at)
    said = words_after(tokens, verb_at + 1, verb)
    if (verb.word.act is Act.TURN or verb.text in _MEASURED) and _is_noun(tokens, low, verb_at):
        before = words_before(tokens, low, verb_at)
        if before.ways or before.amount or before.small:
            said.start = before.start
        said.ways = said.ways or before.ways
        said.amount = said.amount or before.amount
        said.small = said.small or before.small
    return said


def _is_noun(tokens: Sequence[Token], low: int, verb_at: int) -> bool:
    """Return whether a word such as "turn" is a noun after its amount, as in "a 90 degree left turn"."""
    return all(
        token.kind in HARMLESS or token.kind in ARGUMENTS or token.word.act is Act.MAKE for token in tokens[low:verb_at]
    )


def _starts_another(tokens: Sequence[Token], at: int, said: Arguments, verb: Token | None) -> bool:
    """Return whether a token begins another command, as "2 m" does in "turn left 30 degrees 2 m forward"."""
    token, act = tokens[at], verb.word.act if verb else None
    if isinstance(token, Amount):
        if said.closed:
            return False
        if act in (Act.TURN, Act.LOOK):
            return said.amount is not None or token.dimension in (Dimension.LENGTH, Dimension.STEP)
        along = said.amount is not None or Way.FORWARD in said.ways or Way.BACK in said.ways
        angled = token.dimension is Dimension.ANGLE and tokens[at - 1].kind is not Kind.AT and along
        return angled or (said.amount is not None and token.dimension is not Dimension.ANGLE)
    if token.kind is not Kind.WAY or said.closed:
        return False
    if act is Act.TURN and {Way.FORWARD, Way.BACK} & {*token.word.ways}:
        return True
    follows = next((later.kind for later in tokens[at + 1 :] if later.kind not in _PASSED), None)
    return said.amount is not None and said.angle is None and follows is Kind.AMOUNT


def _take(tokens: Sequence[Token], at: int, said: Arguments, *, checked: bool = True) -> None:
    token = tokens[at]
    if token.kind in ARGUMENTS:
        said.last = max(said.last, at + 1)
    if isinstance(token, Amount):
        if not checked or _is_how_far(tokens, at, said):
            _take_amount(token, tokens[at - 1] if at else None, said)
    elif token.kind is Kind.WAY:
        if checked and _is_a_place(tokens, at):
            said.closed = True
        else:
            said.ways.extend(token.word.ways)
    elif token.kind is Kind.SMALL:
        said.small = True
    elif token.kind is Kind.GAZE:
        said.gaze = True
    elif token.kind not in _PASSED and not _leads_to_angle(tokens, at) and token.word.dimension is not Dimension.STEP:
        said.closed = True


def _take_amount(amount: Amount, before: Token | None, said: Arguments) -> None:
    if before is not None and before.kind is Kind.AT and amount.dimension is Dimension.ANGLE:
        said.angle = amount
        said.ways = [way for way in said.ways if way is not Way.FORWARD]
    elif said.amount is None:
        said.amount = amount
    if amount.remark:
        said.remarks.append(amount.remark)


def _leads_to_angle(tokens: Sequence[Token], at: int) -> bool:
    return tokens[at].kind is Kind.AT and at + 1 < len(tokens) and tokens[at + 1].kind is Kind.AMOUNT


def _is_how_far(tokens: Sequence[Token], at: int, said: Arguments) -> bool:
    """Return whether an amount is a distance to move; in "to 1 m from the wall" and "gate 4" it is part of a place."""
    amount, follows = tokens[at], tokens[at + 1] if at + 1 < len(tokens) else None
    assert isinstance(amount, Amount)
    if tokens[at - 1].kind is Kind.TO:
        said.remarks.append(f"'to {amount.text}' names a goal")
        return False
    if follows is None:
        return True
    if follows.text == "from":
        return at + 2 < len(tokens) and tokens[at + 2].text in _HERE
    return follows.text not in _ELSEWHERE and not (amount.dimension is None and follows.kind in _NAMES)


def _is_a_place(tokens: Sequence[Token], at: int) -> bool:
    """Return whether a direction describes a place, as in "to the left of the door" or "the right wall"."""
    behind = at + 1
    attributed = behind < len(tokens) and tokens[behind].text in _ATTRIBUTED
    if attributed:
        behind += 1
    if behind >= len(tokens):
        return False
    follows = tokens[behind]
    if follows.text == "of":
        return behind + 1 >= len(tokens) or tokens[behind + 1].kind is not Kind.AMOUNT
    if follows.kind not in _NAMES:
        return False
    direct = tokens[at - 1].kind in (Kind.VERB, Kind.AMOUNT, Kind.WAY, Kind.SMALL) and " " not in tokens[at].text
    return (
        attributed
        or not direct
        or (tokens[at].word.ways[0] in (Way.LEFT, Way.RIGHT) and tokens[at - 1].kind is Kind.WAY)
    )
