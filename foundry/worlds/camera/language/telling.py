"""Finds the words of a sentence that ask for no motion; each of these words gets a `Bar`, the reason.

A word asks for no motion if it is negated, possible, conditional, or an example ("not", "could", "if", "for example").
A word also asks for no motion if it reports an earlier step or another agent's motion, states a purpose, or postpones
the motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from itertools import pairwise

from foundry.worlds.camera.language.lexicon import Act, Form, Kind, Side
from foundry.worlds.camera.language.sentences import Segment, Token


class Bar(Enum):
    """A reason why a word asks for no motion, such as a negation."""

    NOT = auto()
    WILL_NOT = auto()  # a decision not to
    PERHAPS = auto()
    EXAMPLE = auto()  # also bars the rest of the sentence
    TOLD = auto()  # a report of an earlier step or of another agent, or a purpose
    LATER = auto()  # postponed
    NEXT = auto()  # postponed if the reply names an earlier motion


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
    """Tells which words of a sentence a negation, possibility or condition applies to."""

    def __init__(self) -> None:
        self._not: Bar | None = None
        self._perhaps = False
        self._condition = False

    def bars(self, segment: Segment) -> list[Bar | None]:
        """Return, for each token of a segment, the reason why the token asks for no motion, or None."""
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
    """Mark a verb as asking for no motion if a negation or possibility follows, as in "回転する必要はありません"."""
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


_OPENING = {
    Kind.EARLIER: Bar.TOLD,
    Kind.PURPOSE: Bar.TOLD,
    Kind.AFTER: Bar.TOLD,
    Kind.LATER: Bar.LATER,
    Kind.NEXT: Bar.NEXT,
}
_MARKERS = frozenset((*_OPENING, Kind.PAST, Kind.GOAL, Kind.OTHER))
_CLAUSES = (Kind.PURPOSE, Kind.AFTER, Kind.OTHER, Kind.VERB)
_TIMES = (Kind.EARLIER, Kind.LATER, Kind.NEXT)
_CARRYING = frozenset(
    ("and", "&", "then", "and then", "or", "while")
    + ("然后", "然後", "并", "そして", "次に", "その後", "それから", "、")
)
_GOING_ON = (Form.ING, Form.PAST, Form.THIRD)
_NOUNS = frozenset(("my", "the", "this", "that", "last", "previous", "first", "a"))
_DETERMINED = (Kind.ARTICLE, Kind.OTHER)
_BEFORE_NOUNS = frozenset(("the", "this", "that", "some", "second", "one", "two"))
_WILL = frozenset(("will", "shall"))
_BUT = frozenset(("but", "however", "但", "但是"))
_WISHES = frozenset(("want", "like", "wish", "hope", "想"))
_LABEL = ":"


@dataclass(slots=True)
class _Scope:
    """A reason why the next words of a sentence ask for no motion, and the kind of the word that began it."""

    told: Bar
    kind: Kind
    wide: bool = False  # whether it goes on after a comma


@dataclass(slots=True)
class _Seen:
    """Notes on the part of a segment that was read so far.

    Attributes:
        fresh: whether the speaker is the subject again, as after "I".
        other: index of the last word for another agent, or None.
        motion: index of the last verb, or None.
        bars: for each token, the reason why it asks for no motion, or None.
    """

    fresh: bool = False
    other: int | None = None
    motion: int | None = None
    bars: list[Bar | None] = field(default_factory=list)


class Telling:
    """Tells which segments of a sentence only report, state a purpose or postpone a motion, and so ask for none."""

    def __init__(self, segments: Sequence[Segment]) -> None:
        self._segments = segments
        self._scope: _Scope | None = None
        self._past_to = _past_to(segments)
        self._put_off = {
            index - 1: Bar.LATER if segment.tokens[0].kind is Kind.LATER else Bar.NEXT
            for index, segment in enumerate(segments)
            if segment.joint is not None and segment.joint.text == "(" and _is_put_off(segment.tokens[0])
        }
        for index, segment in enumerate(segments[1:]):
            if _is_objection(segment) and any(token.text in _WISHES for token in segments[index].tokens):
                self._put_off[index] = Bar.LATER

    def told(self, index: int) -> list[Bar | None]:
        """Return, for each token of a segment, the reason why the token asks for no motion, or None."""
        segment = self._segments[index]
        tokens = segment.tokens
        if (index, len(tokens)) <= self._past_to:
            return [Bar.TOLD] * len(tokens)
        self._enter(index)
        seen = _Seen()
        for at, token in enumerate(tokens):
            if self._scope is not None or token.kind in _MARKERS:
                self._pass(token, index, at)
            bar = self._scope.told if self._scope is not None else None
            if token.kind is Kind.VERB:
                bar = bar or self._of_verb(segment, at, seen)
                seen.motion = at
            elif token.kind is Kind.OTHER:
                seen.other = at
            elif token.kind is Kind.FRESH and seen.other is None:
                seen.fresh = seen.fresh or token.text not in _WILL
            seen.bars.append(Bar.TOLD if (index, at + 1) <= self._past_to else bar)
        self._leave(index, seen)
        return seen.bars

    def _enter(self, index: int) -> None:
        """Begin a segment; forget why the last one asks for no motion, unless the same reason applies here."""
        scope, segment = self._scope, self._segments[index]
        if scope is None or segment.joint is None:
            return
        starts = [token for token in segment.tokens[:2] if token.kind in (Kind.FRESH, Kind.NOW)]
        fresh = any(token.text not in _WILL for token in starts)
        breaks, carries = segment.joint.kind is Kind.BREAK, segment.joint.text in _CARRYING
        if scope.wide:
            heads = self._segments[index - 1].tokens[-1].kind is Kind.GOAL
            keeps = heads or carries or (breaks and segment.joint.text != _LABEL and not fresh)
        elif breaks and scope.kind in _TIMES:
            keeps = self._leads_on(index, scope, starts)
        elif scope.kind in (Kind.OTHER, Kind.VERB):
            keeps = not fresh and (carries or breaks) and self._goes_on(index, scope, carries=carries)
        else:
            keeps = carries and not fresh
        if not keeps:
            self._scope = None

    def _leads_on(self, index: int, scope: _Scope, starts: Sequence[Token]) -> bool:
        """Return whether the segment before this one only states a time, such as "in the last step,"."""
        before = self._segments[index - 1].tokens
        if _is_only_time(before):
            return True
        will = any("will" in token.text or "ll" in token.text for token in starts)
        return will and scope.kind is Kind.LATER and before[0].kind is Kind.LATER

    def _goes_on(self, index: int, scope: _Scope, *, carries: bool) -> bool:
        """Return whether a segment without a subject continues a report that began in an earlier segment."""
        segment, before = self._segments[index], self._segments[index - 1].tokens[-1].text
        if segment.joint is not None and segment.joint.text == _LABEL:
            return False
        verb = next((token.word for token in segment.tokens if token.kind is Kind.VERB), None)
        if verb is None or verb.form in _GOING_ON:
            return True
        told_on = verb.side is not Side.AFTER or _WILL & {before, segment.tokens[0].text}
        return carries and scope.kind is Kind.OTHER and bool(told_on)

    def _pass(self, token: Token, index: int, at: int) -> None:
        kind, tokens = token.kind, self._segments[index].tokens
        if self._ends(tokens, at):
            self._scope = None
        elif kind in _OPENING and (kind is not Kind.AFTER or self._is_done(index, at)):
            self._scope = _Scope(_OPENING[kind], kind)
        elif kind is Kind.PAST and token.word.reach == "after":
            self._scope = _Scope(Bar.TOLD, kind)
        elif (kind is Kind.GOAL and _is_told_goal(tokens, at)) or (kind is Kind.OTHER and token.word.reach == "both"):
            self._scope = _Scope(Bar.TOLD, kind, wide=True)

    def _ends(self, tokens: Sequence[Token], at: int) -> bool:
        if self._scope is None:
            return False
        if tokens[at].kind in (Kind.NOW, Kind.FIRST, Kind.RETRACT):
            return True
        if self._scope.kind is Kind.PURPOSE and tokens[at].text in _IS_TO | {"is"}:
            return True
        return self._scope.kind in _CLAUSES and _is_subject(tokens, at)

    def _is_done(self, index: int, at: int) -> bool:
        """Return whether "after" and a motion report the past; "after turning left, move forward" is a plan."""
        if not any(token.kind is Kind.VERB for token in self._segments[index].tokens[at + 1 :]):
            return False
        following = self._segments[1].tokens if index == 0 and len(self._segments) > 1 else ()
        first = next((token for token in following if token.kind is not Kind.FILLER), None)
        return first is None or first.kind is not Kind.VERB or first.word.form is not Form.PLAIN

    def _of_verb(self, segment: Segment, at: int, seen: _Seen) -> Bar | None:
        """Return the reason why a verb asks for no motion, by its form or the words before it; else None."""
        tokens, word = segment.tokens, segment.tokens[at].word
        if word.form is Form.PAST:
            self._scope = _Scope(Bar.TOLD, Kind.VERB)
            return Bar.TOLD
        if _is_of_another(tokens, at, seen):
            self._scope = _Scope(Bar.TOLD, Kind.OTHER)
            return Bar.TOLD
        if word.form is Form.ING and (_is_past(tokens) or (at and tokens[at - 1].text in ("for", "of"))):
            return Bar.TOLD
        labelled = segment.joint is not None and segment.joint.text == _LABEL
        alone = labelled or len(self._segments) == 1
        return Bar.TOLD if _is_purpose(tokens, at, seen.motion, alone=alone) or _is_noun(tokens, at) else None

    def _leave(self, index: int, seen: _Seen) -> None:
        """Mark a segment as asking for no motion if one of its words, such as "later", names another time."""
        tokens = self._segments[index].tokens
        if self._scope is not None and self._scope.kind in (Kind.LATER, Kind.NEXT):
            seen.bars[:] = [bar or self._scope.told for bar in seen.bars]
        if index in self._put_off:
            seen.bars[:] = [bar or self._put_off[index] for bar in seen.bars]
        named = seen.other is not None and not seen.fresh and any(token.kind is Kind.IS for token in tokens)
        if named and self._scope is None:
            self._scope = _Scope(Bar.TOLD, Kind.OTHER)
        if Bar.TOLD in seen.bars and any(token.kind is Kind.EARLIER for token in tokens) and _has_only_forms(tokens):
            seen.bars[:] = [Bar.TOLD] * len(tokens)


def _is_objection(segment: Segment) -> bool:
    """Return whether a segment says that a motion is not possible, as in "but the way is blocked"."""
    return segment.joint is not None and segment.joint.text in _BUT and len(segment.tokens) > 2


def _is_put_off(token: Token) -> bool:
    return token.kind in (Kind.LATER, Kind.NEXT) or token.text.startswith("next ")


def _past_to(segments: Sequence[Segment]) -> tuple[int, int]:
    """Return the segment and token up to which a sentence reports the past, as in "...進み、...回転しましたが"."""
    for index in range(len(segments) - 1, -1, -1):
        for at in range(len(segments[index].tokens) - 1, -1, -1):
            token = segments[index].tokens[at]
            past_verb = token.kind is Kind.VERB and token.word.form is Form.PAST and token.word.side is Side.BEFORE
            if past_verb or (token.kind is Kind.PAST and token.word.reach == "before"):
                return index, at + 1
    return -1, 0


def _is_only_time(tokens: Sequence[Token]) -> bool:
    return not any(token.kind in (Kind.VERB, Kind.UNKNOWN, Kind.STAY) for token in tokens)


def _is_subject(tokens: Sequence[Token], at: int) -> bool:
    """Return whether a token begins a new clause, as "I" does in "in order to see it I move"."""
    token, before = tokens[at], tokens[at - 1].kind if at else None
    return token.kind is Kind.FRESH and token.text not in _WILL and before not in (Kind.PURPOSE, Kind.AFTER, None)


def _is_told_goal(tokens: Sequence[Token], at: int) -> bool:
    """Return whether the words after "goal" say what the goal is, as in "the goal is to" or "Task:"."""
    after = tokens[at + 1 :]
    to = any(first.text == "to" and then.kind is Kind.VERB for first, then in pairwise(after))
    return to or not after or any(token.text in _IS_TO or token.kind is Kind.PURPOSE for token in after)


_IS_TO = frozenset(("is to", "was to", "是"))


def _is_of_another(tokens: Sequence[Token], at: int, seen: _Seen) -> bool:
    """Return whether the subject of a verb is another agent, as in "the other robot turns"."""
    word, before = tokens[at].word, tokens[at - 1] if at else None
    if before is None or (before.kind is Kind.FRESH and before.text not in _WILL):
        return False
    follows_other = seen.other is not None and (seen.motion is None or seen.motion < seen.other)
    if word.form is Form.ING:
        return follows_other or _is_progressive(tokens, at) or _is_reduced(tokens, at)
    if follows_other and not seen.fresh and seen.other is not None:
        between = tokens[seen.other + 1 : at]
        plural = tokens[seen.other].word.scale and not between
        due = (
            before.text == "to" and tokens[seen.other].text != "it" and any(token.kind is Kind.IS for token in between)
        )
        return plural or due or word.side is not Side.AFTER or before.text in _WILL
    return False


def _is_progressive(tokens: Sequence[Token], at: int) -> bool:
    """Return whether the verb after "is" has a subject of its own, as in "an astronaut is turning"."""
    joins = [index for index in range(at) if tokens[index].kind is Kind.IS]
    if not joins:
        return False
    between, subject = tokens[joins[-1] + 1 : at], tokens[: joins[-1]]
    named = any(token.kind in (Kind.UNKNOWN, Kind.OTHER, Kind.CLOSE) for token in subject)
    return named and all(token.kind in (Kind.FILLER, Kind.EARLIER) for token in between)


def _is_reduced(tokens: Sequence[Token], at: int) -> bool:
    """Return whether a verb belongs to the noun right before it, as in "a person walking"."""
    if tokens[at - 1].kind is not Kind.UNKNOWN:
        return False
    return any(token.kind in _DETERMINED or token.text in _BEFORE_NOUNS for token in tokens[max(0, at - 4) : at - 1])


def _is_past(tokens: Sequence[Token]) -> bool:
    return any(token.word.form is Form.PAST and token.kind is not Kind.VERB for token in tokens)


def _has_only_forms(tokens: Sequence[Token]) -> bool:
    """Return whether all verbs of a segment have forms such as "moving", which give no command."""
    return all(token.word.form in _GOING_ON for token in tokens if token.kind is Kind.VERB)


def _is_purpose(tokens: Sequence[Token], at: int, motion: int | None, *, alone: bool) -> bool:
    """Return whether a verb states a purpose, as in "to move on, I need" or "turn left to look at"."""
    start = at
    while start and tokens[start - 1].kind in (Kind.FILLER, Kind.NOT) and tokens[start - 1].text != "to":
        start -= 1
    if not start or tokens[start - 1].text != "to":
        return False
    if start == 1:
        strange = (Kind.UNKNOWN, Kind.FRESH, Kind.IS, Kind.SEE, Kind.CLOSE)
        return not alone or any(token.kind in strange for token in tokens)
    return motion is not None and any(
        token.kind in (Kind.WAY, Kind.AMOUNT, Kind.SMALL) for token in tokens[motion + 1 : start]
    )


def _is_noun(tokens: Sequence[Token], at: int) -> bool:
    """Return whether a word such as "turn" is a noun in a report, as in "my turn to the right has shown"."""
    if tokens[at].word.act not in (Act.TURN, Act.MOVE) or not at or tokens[at - 1].text not in _NOUNS:
        return False
    return _is_past(tokens[at + 1 :])
