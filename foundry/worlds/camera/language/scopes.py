"""What bars a word from being a command: "not", "could", "if", "for example"."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum, auto

from foundry.worlds.camera.language.sentences import Segment
from foundry.worlds.camera.language.tokens import Token
from foundry.worlds.camera.language.words import Kind


class Bar(Enum):
    """Why a word is no command."""

    NOT = auto()
    WILL_NOT = auto()  # not, by decision
    PERHAPS = auto()
    EXAMPLE = auto()  # nor is anything behind it
    TOLD = auto()  # of an earlier step, of somebody else, or as a purpose
    LATER = auto()  # put off
    NEXT = auto()  # put off if the reply says what comes before


_CARRIED = frozenset(("and", "&", "nor"))
_BINDING = frozenset(
    (
        *(Kind.VERB, Kind.STAY, Kind.PAUSE, Kind.WAY, Kind.AMOUNT, Kind.SMALL, Kind.POSSIBLE),
        *(Kind.FILLER, Kind.TO, Kind.FRESH, Kind.BY, Kind.ARTICLE, Kind.PLACE),
        *(Kind.EARLIER, Kind.NOW, Kind.LATER, Kind.NEXT),
    )
)
_RESETS = frozenset(("instead", "rather"))


class Scopes:
    """Follows the scopes through the segments of one sentence."""

    def __init__(self) -> None:
        self._not: Bar | None = None
        self._perhaps = False
        self._condition = False

    def bars(self, segment: Segment) -> list[Bar | None]:
        """Return what bars each token of the next segment."""
        self._enter(segment)
        bars = [self._pass(token) for token in segment.tokens]
        _bar_backwards(segment.tokens, bars)
        return bars

    def _enter(self, segment: Segment) -> None:
        joint = segment.joint
        carried = joint is not None and (joint.kind is Kind.OR or joint.text in _CARRIED)
        fresh = bool(segment.tokens) and segment.tokens[0].kind is Kind.FRESH
        if not carried or fresh:
            self._not, self._perhaps = None, False
        if not carried:
            self._condition = False

    def _pass(self, token: Token) -> Bar | None:
        """Take one token into account and return what bars it."""
        if token.kind is Kind.NOT:
            self._not = _bar_of(token)
        elif token.kind is Kind.SEE or token.text in _RESETS:
            self._not, self._perhaps = None, False
        elif token.kind is Kind.POSSIBLE:
            self._perhaps = True
        elif token.kind is Kind.CONDITION:
            self._condition = True
        elif token.kind is Kind.EXAMPLE:
            return Bar.EXAMPLE
        elif token.kind not in _BINDING:
            self._perhaps = False
        if self._not is not None:
            return self._not
        return Bar.PERHAPS if self._perhaps or self._condition else None


def _bar_backwards(tokens: Sequence[Token], bars: list[Bar | None]) -> None:
    """Bar the verb before a word that follows it: "回転する必要はありません"."""
    for at, token in enumerate(tokens):
        if token.word.reach == "after":
            continue
        verbs = [earlier for earlier in range(at) if tokens[earlier].kind is Kind.VERB]
        if verbs:
            bars[verbs[-1]] = bars[verbs[-1]] or _bar_of(token)
        if token.word.reach == "before":
            bars[at:] = [None if bar is _bar_of(token) else bar for bar in bars[at:]]


def _bar_of(token: Token) -> Bar:
    if token.kind is Kind.POSSIBLE:
        return Bar.PERHAPS
    return Bar.WILL_NOT if token.word.decides else Bar.NOT
