"""Collects the words that belong to a verb."""

from __future__ import annotations

from collections.abc import Sequence

from foundry.worlds.camera.language.amounts import Amount
from foundry.worlds.camera.language.mentions import Arguments
from foundry.worlds.camera.language.tokens import Token
from foundry.worlds.camera.language.words import Act, Dimension, Kind, Side, Way

HARMLESS = frozenset(
    (
        *(Kind.FILLER, Kind.TO, Kind.OF, Kind.BY, Kind.ARTICLE, Kind.PLACE, Kind.FRESH, Kind.SMALL, Kind.GAZE, Kind.IS),
        *(Kind.EARLIER, Kind.NOW, Kind.LATER, Kind.NEXT, Kind.FIRST, Kind.RETRACT),
    )
)
"""Kinds of word that change nothing in a command."""

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
"""Verbs of motion that are nouns behind an amount: "a 2 m step forward"."""


def words_after(tokens: Sequence[Token], start: int, verb: Token | None) -> Arguments:
    """Return what the tokens from `start` on say about a verb, up to the next one.

    Args:
        tokens: the tokens of one segment.
        start: index behind the verb.
        verb: the verb, or None when the words stand alone.
    """
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
    """Return what the tokens right before a verb, not before `low`, say about it."""
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
    """Return what stands on either side of a verb: directions before it or right behind it, the amount behind it."""
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
    """Return the words that belong to the verb at `verb_at`; those before `low` belong to another one."""
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
    """Tell whether nothing but words of the turn stands before it: "a 90 degree left turn"."""
    return all(
        token.kind in HARMLESS or token.kind in ARGUMENTS or token.word.act is Act.MAKE for token in tokens[low:verb_at]
    )


def _starts_another(tokens: Sequence[Token], at: int, said: Arguments, verb: Token | None) -> bool:
    """Tell whether a token belongs to a command of its own: "turn left 30 degrees 2 m forward"."""
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
    """Tell whether an amount says how far to move, and not where something is: "to 1 m from the wall", "gate 4"."""
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
    """Tell whether a direction says where something is: "to the left of the door", "the right wall"."""
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
