"""Finds the motions that sentences ask for, not motions that are only mentioned, and makes one command of them."""

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace

from foundry.records import Outcome
from foundry.texts import without_surrogates
from foundry.worlds.camera.language import Command, Limits, Translation, limited
from foundry.worlds.camera.language.arguments import (
    ARGUMENTS,
    HARMLESS,
    Arguments,
    Category,
    Mention,
    bare_mention,
    collect,
    made,
    mention,
    words_after,
)
from foundry.worlds.camera.language.lexicon import Act, Dimension, Form, Kind, Way
from foundry.worlds.camera.language.sentences import Amount, Segment, Sentence, Token, find_sentences
from foundry.worlds.camera.language.telling import Bar, Scopes, Telling

_AND = frozenset(("and", "&"))
_BUT = frozenset(("but", "而是"))
_ENABLING = ("allow", "enabl", "let", "help", "give")
_THEN = frozenset(("then", "and then", "and"))
_POSITIONAL = frozenset(("ahead", "straight ahead", "directly ahead", "dead ahead"))


class _Reader:
    def __init__(self, sentence: Sentence) -> None:
        self._sentence = sentence
        self._scopes = Scopes()
        self._telling = Telling(sentence.segments)
        self._found: list[Mention] = []
        self._told_of: list[Mention] = []
        self._act: Act | None = None
        self._verbs = False
        self._strange = not sentence.whole
        self._known = sentence.whole and all(map(_is_plain, sentence.segments))
        self._index = 0
        self._later = False

    def read(self) -> list[Mention]:
        """Return the motions that the sentence asks for or refuses, in order, then the motions that it only reports."""
        for index, segment in enumerate(self._sentence.segments):
            self._index = index
            if not self._segment(segment):
                break
        if self._is_order() and any(mention.wanted for mention in self._found):
            self._found.insert(0, Mention(Category.ORDER, wanted=False))
        return self._found + self._told_of

    def _is_order(self) -> bool:
        """Return whether the sentence begins with a label of the answer: "Next movement: ..."."""
        if len(self._sentence.segments) < 2:
            return False
        label, answer = self._sentence.segments[:2]
        named = label.tokens[-1].text.split()[-1] in _ANSWERS and all(
            token.kind in (Kind.FILLER, Kind.NOW) for token in label.tokens
        )
        return named and label.joint is None and answer.joint is not None and answer.joint.text == ":"

    def _segment(self, segment: Segment) -> bool:
        """Read a segment; return False if the rest of the sentence is an example, which asks for nothing."""
        tokens = segment.tokens
        before = len(self._found)
        bars, own_bar = self._scopes.bars(segment), self._told(segment)
        if any(own_bar):
            bars = [_stronger(*pair) for pair in zip(bars, own_bar, strict=True)]
        low = 0
        for at, token in enumerate(tokens):
            if bars[at] is Bar.EXAMPLE:
                return False
            if token.kind is Kind.VERB and at >= low:
                low = self._verb(segment, bars, low, at)
            elif token.kind in (Kind.STAY, Kind.PAUSE):
                self._stay(segment, bars, at)
            elif token.kind is Kind.DONE and bars[at] is None and self._is_done(tokens, at):
                self._add(Mention(Category.STAY, text=token.text, later=True))
            elif token.kind in (Kind.FIRST, Kind.RETRACT) or token.text in _INSTEAD:
                self._take_back(token)
            self._strange = self._strange or _is_strange(token)
        self._bare(segment, bars, low, len(tokens))
        if segment.joint is not None and segment.joint.kind is Kind.OR:
            self._drop_alternatives(before)
        return True

    def _verb(self, segment: Segment, bars: Sequence[Bar | None], low: int, at: int) -> int:
        """Read a verb and the words that belong to it; return the index of the next word."""
        tokens, verb = segment.tokens, segment.tokens[at]
        said = collect(tokens, low, at)
        if verb.word.act is Act.MAKE and not _makes(tokens, at, said):
            return at + 1
        if verb.text == "step" and said.amount is not None and said.amount.dimension is None and not said.ways:
            return said.end  # "step 3:" numbers the steps
        self._bare(segment, bars, low, said.start)
        self._verbs = True
        bar = bars[at]
        if bar is None and self._is_description(segment, at, said):
            bar = Bar.PERHAPS
        word = made(said) if verb.word.act is Act.MAKE else verb.word
        self._later = bar is Bar.NEXT
        self._note(
            None if self._later else bar, mention(word, said), verb, said, _joined(tokens[said.start : said.last])
        )
        self._later = False
        return said.end

    def _note(self, bar: Bar | None, read: Mention | str, verb: Token, said: Arguments, text: str) -> None:
        act = verb.word.act
        negated = bar is Bar.NOT or bar is Bar.WILL_NOT or verb.word.negated
        if negated and isinstance(read, str) and not said.ways and not said.closed:
            if act is Act.MOVE and (bar is Bar.WILL_NOT or verb.word.negated):
                self._add(Mention(Category.STAY, text=text if verb.word.negated else f"not {text}"))
            elif act is Act.TURN:
                self._add(Mention(Category.TURN, text=text, wanted=False))
        elif isinstance(read, str):
            self._act = act if bar is None else self._act
        elif negated:
            self._add(replace(read, text=text, wanted=False))
        elif bar in (Bar.TOLD, Bar.LATER):
            self._told_of.append(replace(read, text=text, wanted=False, told=True))
        elif bar is None:
            self._act = act
            self._add(replace(read, text=text))

    def _add(self, mention: Mention) -> None:
        self._found.append(replace(mention, later=mention.later or self._later, segment=self._index))

    def _told(self, segment: Segment) -> list[Bar | None]:
        """Return, for each token, a reason if it reports, states a purpose or postpones a motion; else None."""
        bars = self._telling.told(self._index)
        if self._index == 0 and segment.tokens[0].kind is Kind.OPTION:
            return [Bar.EXAMPLE] * len(bars)
        return bars

    def _take_back(self, token: Token) -> None:
        """Delete the motions of the sentence or reply so far, since a word such as "no, wait" has revoked them."""
        if token.kind in (Kind.FIRST, Kind.RETRACT):
            while any(mention.wanted for mention in self._found):
                self._found.pop()
        if token.kind is not Kind.FIRST and all(mention.wanted for mention in self._found):
            self._found.insert(0, Mention(Category.RETRACT, wanted=False, segment=-1))

    def _is_description(self, segment: Segment, at: int, said: Arguments) -> bool:
        """Return whether a verb describes an event and asks for no motion, as "turns" does in "the wall turns"."""
        tokens, word = segment.tokens, segment.tokens[at].word
        if word.form is Form.THIRD:
            named = any(token.kind is Kind.GAZE or token.text in ("the", "my", "your") for token in tokens[:at])
            self._strange = self._strange or named
            return self._strange
        if word.form is not Form.ING:
            return False
        after = tokens[at + 1 :]
        if any(token.kind in (Kind.IS, Kind.POSSIBLE) or token.text in ("will", "i will") for token in after) or any(
            token.kind is Kind.PURPOSE and any(stem in token.text for stem in _ENABLING) for token in after
        ):
            return True
        if said.amount is not None:
            return False
        introduced = any(token.kind in (Kind.FRESH, Kind.BY) or token.text == "keep" for token in tokens[:at])
        return word.act is Act.LOOK or (not introduced and self._goes_on())

    def _goes_on(self) -> bool:
        following = self._sentence.segments[self._index + 1 :]
        return bool(following) and following[0].joint is not None and following[0].joint.kind is Kind.BREAK

    def _stay(self, segment: Segment, bars: Sequence[Bar | None], at: int) -> None:
        tokens, pause = segment.tokens, segment.tokens[at].kind is Kind.PAUSE
        ends_a_plan = self._index == 0 and segment.joint is not None and segment.joint.text in _THEN
        if bars[at] is not None or ends_a_plan or tokens[at].word.form is Form.PAST:
            return
        follows = tokens[at + 1] if at + 1 < len(tokens) else None
        if follows is None:
            plain = all(token.kind in HARMLESS for token in tokens[:at])
            stays = not pause or (plain and not self._verbs and not self._goes_on())
        elif pause:
            stays = follows.kind is Kind.PLACE
        else:
            stays = follows.kind in HARMLESS | {Kind.CONDITION, Kind.AT} or follows.text == "in"
        if stays:
            self._add(Mention(Category.STAY, text=_joined(tokens[at:])))

    def _is_done(self, tokens: Sequence[Token], at: int) -> bool:
        """Return whether "task completed" is stated as a fact; in "task completed: no" it is not."""
        segments = self._sentence.segments
        following = segments[self._index + 1].joint if self._index + 1 < len(segments) else None
        conditions = (token.text for segment in segments for token in segment.tokens if token.kind is Kind.CONDITION)
        plain = all(token.kind in HARMLESS - {Kind.OF} for token in (*tokens[:at], *tokens[at + 1 :]))
        return plain and _REASONS.issuperset(conditions) and (following is None or following.text != ":")

    def _bare(self, segment: Segment, bars: Sequence[Bar | None], low: int, high: int) -> None:
        """Read words without a verb: "30 degrees to the left", "forward"."""
        tokens = segment.tokens[low:high]
        if not any(token.kind in ARGUMENTS for token in tokens):
            return
        plain = all(token.kind in HARMLESS or token.kind in ARGUMENTS for token in tokens)
        if not plain or any(bar is not Bar.NEXT for bar in bars[low:high] if bar is not None):
            return
        self._later = Bar.NEXT in bars[low:high]
        self._plain_words(segment, tokens)
        self._later = False

    def _plain_words(self, segment: Segment, tokens: Sequence[Token]) -> None:
        said = words_after(tokens, 0, None)
        if said.end < len(tokens):
            return
        if said.ways:
            self._bare_way(segment, tokens, said)
        elif self._found and self._found[-1].wanted and _is_open(self._found[-1].amount, said.amount):
            self._complete(said)

    def _bare_way(self, segment: Segment, tokens: Sequence[Token], said: Arguments) -> None:
        if self._makes_diagonal(segment, said):
            return
        shared = self._known and not self._found and segment.joint is not None and segment.joint.text == ":"
        if segment.joint is not None and segment.joint.text in _BUT and self._found and not self._found[-1].wanted:
            self._act, shared = _ACTS.get(self._found[-1].category), True
        read = bare_mention(said, self._act, shared=shared)
        if isinstance(read, Mention) and self._is_licensed(tokens, said, read):
            self._add(replace(read, text=_joined(tokens)))
        elif segment.joint is not None and segment.joint.kind is Kind.OR and self._found:
            self._found.pop()

    def _is_licensed(self, tokens: Sequence[Token], said: Arguments, read: Mention) -> bool:
        """Return whether words without a verb ask for a motion: words that stand alone or follow another command do."""
        if any(token.text in _POSITIONAL for token in tokens) and not self._known:
            return False
        if self._known or any(mention.wanted and not mention.later for mention in self._found) or self._corrects():
            return True
        along = read.category is not Category.TRANSLATE or bool({Way.FORWARD, Way.BACK} & {*said.ways})
        return self._act is not None and said.amount is not None and along

    def _corrects(self) -> bool:
        """Return whether the words follow a phrase such as "not left, but" or "I need to get closer:"."""
        segment, before = self._sentence.segments[self._index], self._sentence.segments[max(self._index - 1, 0)].tokens
        joint = segment.joint.text if segment.joint is not None and self._index else ""
        if joint in _BUT:
            return any(not mention.wanted for mention in self._found)
        first_person = any(token.kind is Kind.FRESH for token in before)
        return joint == ":" and first_person and not any(token.kind is Kind.IS for token in before)

    def _makes_diagonal(self, segment: Segment, said: Arguments) -> bool:
        """Join two segments, such as "move forward" and "to the left", to one motion; return whether they fit."""
        joint = segment.joint
        if joint is None or joint.text not in _AND or not self._found or self._found[-1].segment != self._index - 1:
            return False
        last = self._found[-1]
        behind = self._sentence.segments[self._index - 1].tokens[-1].kind is not Kind.WAY
        if last.category is not Category.TRANSLATE or (last.amount is not None and behind) or last.small:
            return False
        if not last.wanted or (last.amount is not None and said.amount is not None):
            return False
        if said.amount is not None and said.amount.dimension is Dimension.ANGLE:
            return False
        along = {0.0: Way.FORWARD, 180.0: Way.BACK}.get(last.direction)
        if along is None or not {*said.ways} <= {Way.LEFT, Way.RIGHT}:
            return False
        said.ways.insert(0, along)
        said.amount = said.amount or last.amount
        read = bare_mention(said, Act.MOVE)
        if isinstance(read, Mention):
            self._found[-1] = replace(read, text=f"{last.text} {joint.text} {segment.text}", segment=last.segment)
        return True

    def _complete(self, said: Arguments) -> None:
        """Add an amount to the last motion if the amount follows later, as in "turn right (30 degrees)"."""
        last, amount = self._found[-1], said.amount
        if last.category is Category.STAY or (amount is None and not said.small):
            return
        along = last.category is Category.TRANSLATE
        lengths = (None, Dimension.LENGTH, Dimension.STEP)
        if amount is not None and amount.dimension not in (lengths if along else _ANGLES):
            return
        if amount is not None and amount.number < 0:
            self._found.pop()
            return
        text = f"{last.text}, {amount.text}" if amount is not None else last.text
        self._found[-1] = replace(last, amount=amount, small=last.small or said.small, text=text)

    def _drop_alternatives(self, before: int) -> None:
        """Drop both motions of an undecided choice such as "turn left or move forward"."""
        if len(self._found) > before > 0 and self._found[before].wanted:
            del self._found[before - 1 :]


_ANGLES = (None, Dimension.ANGLE)
_ACTS = {Category.TRANSLATE: Act.MOVE, Category.TURN: Act.TURN, Category.GAZE: Act.LOOK}
_ANSWERS = frozenset(("movement", "action", "move", "decision", "command", "answer"))
_REASONS = frozenset(("since", "because"))
_INSTEAD = frozenset(("instead", "代わりに", "かわりに"))


def _stronger(bar: Bar | None, new: Bar | None) -> Bar | None:
    return bar if bar is Bar.EXAMPLE or new is None or (new is Bar.NEXT and bar is not None) else new


def _makes(tokens: Sequence[Token], at: int, said: Arguments) -> bool:
    """Return whether "take" and its words ask for a motion, as in "take a step back" or "take a left"."""
    if said.end < len(tokens) and tokens[said.end].kind is Kind.VERB:
        return False
    if said.amount is not None or any(token.word.dimension is Dimension.STEP for token in tokens[at + 1 : said.end]):
        return True
    article = at + 1 < len(tokens) and tokens[at + 1].kind is Kind.ARTICLE
    return article and bool(said.ways) and {*said.ways} <= {Way.LEFT, Way.RIGHT}


def _is_open(amount: Amount | None, further: Amount | None) -> bool:
    """Return whether a second amount states the first one more exactly, as in "a step forward, about 1.5 m"."""
    if amount is None:
        return True
    one_step = amount.dimension is Dimension.STEP and amount.number == 1
    return one_step and further is not None and further.dimension is Dimension.LENGTH


def _joined(tokens: Sequence[Token]) -> str:
    return " ".join(token.text for token in tokens)


def _is_plain(segment: Segment) -> bool:
    return not any(map(_is_strange, segment.tokens))


def _is_strange(token: Token) -> bool:
    return token.kind not in HARMLESS and token.kind not in ARGUMENTS and token.kind not in (Kind.VERB, Kind.NOT)


_LONGEST_QUOTE = 80


@dataclass(slots=True)
class _Latest:
    """The latest motion of each kind in the reply so far; motions that the reply has revoked are left out."""

    mentions: dict[Category, Mention] = field(default_factory=dict)
    overridden: Counter[Category] = field(default_factory=Counter)
    refused: int = 0
    told: int = 0
    retracting: bool = False
    ordered: bool = False

    def take(self, mentions: Iterable[Mention]) -> None:
        mentions = [motion for motion in mentions if not self._is_retraction(motion)]
        stays = [motion for motion in mentions if motion.category is Category.STAY]
        if stays:
            self._retract()
            self.mentions = {Category.STAY: stays[-1]}
        for motion in mentions:
            if motion.told:
                self.told += 1
            elif not motion.wanted:
                self._refuse(motion)
            elif motion.category is not Category.STAY:
                self._retract()
                self.overridden[motion.category] += motion.category in self.mentions
                self.mentions[motion.category] = motion
                self.mentions.pop(Category.STAY, None)

    def _is_retraction(self, motion: Mention) -> bool:
        first_order = motion.category is Category.ORDER and not self.ordered
        self.ordered = self.ordered or first_order
        self.retracting = self.retracting or first_order or motion.category is Category.RETRACT
        return motion.category in (Category.RETRACT, Category.ORDER)

    def _retract(self) -> None:
        """Delete the earlier motions if a word such as "no, wait" has revoked them."""
        if self.retracting:
            self.mentions.clear()
            self.retracting = False

    def _refuse(self, motion: Mention) -> None:
        self.refused += 1
        earlier = self.mentions.get(motion.category)
        if earlier is not None and motion.direction in (earlier.direction, _ANY[motion.category]):
            del self.mentions[motion.category]


_ANY = {Category.TRANSLATE: None, Category.TURN: 0.0, Category.GAZE: 0.0}
"""For each kind of motion, the direction that stands for all directions: "do not turn" forbids every turn."""


def resolve(text: str, limits: Limits) -> Command:
    """Return the command in a cleaned text."""
    latest = _Latest()
    sentences = [[] if sentence.question else _Reader(sentence).read() for sentence in find_sentences(text)]
    at_once = any(motion.wanted and not motion.later for mentions in sentences for motion in mentions)
    for mentions in sentences:
        latest.take(motion for motion in mentions if not (at_once and motion.later))
    latest_mentions, notes = latest.mentions, list[str]()
    for motion in latest_mentions.values():
        notes.extend(_origin(motion, latest.overridden[motion.category]))
    command = Command(
        translate=_translation(latest_mentions.get(Category.TRANSLATE), limits, notes),
        turn=_angle(latest_mentions.get(Category.TURN), limits.default_turn_deg, limits.max_turn_deg, limits, notes),
        gaze=_angle(latest_mentions.get(Category.GAZE), limits.default_gaze_deg, limits.max_gaze_deg, limits, notes),
        stay=Category.STAY in latest_mentions,
        outcome=_outcome(latest_mentions.values()),
    )
    if latest.refused:
        notes.append(f"named as not to be done: {latest.refused}")
    if latest.told:
        notes.append(f"told and not asked for: {latest.told}")
    return replace(command, notes=tuple(notes or ["no movement found"]))


def _outcome(mentions: Collection[Mention]) -> Outcome:
    if not mentions:
        return Outcome.UNREADABLE
    return Outcome.REPAIRED if any(motion.inferred for motion in mentions) else Outcome.CHOSEN


def _origin(motion: Mention, overridden: int) -> Iterable[str]:
    """Yield the words that name a motion, and remarks on how they were read."""
    name = motion.category.value
    text = without_surrogates(motion.text)
    yield f"{name}: '{text if len(text) <= _LONGEST_QUOTE else text[: _LONGEST_QUOTE - 3] + '...'}'"
    yield from (f"{name}: {remark}" for remark in motion.remarks)
    if overridden:
        yield f"{name}: the latest of {overridden + 1}"


def _translation(motion: Mention | None, limits: Limits, notes: list[str]) -> Translation | None:
    if motion is None:
        return None
    asked = _asked(motion, limits.default_distance_m, "m", limits, notes)
    return Translation(motion.direction, limited("translate", asked, limits.max_distance_m, "m", notes))


def _angle(
    motion: Mention | None, default: float, largest: float | None, limits: Limits, notes: list[str]
) -> float | None:
    if motion is None:
        return None
    asked = motion.direction * abs(_asked(motion, motion.degrees or default, "degrees", limits, notes))
    return limited(motion.category.value, asked, largest, "degrees", notes) + 0.0  # no negative zero


def _asked(motion: Mention, default: float, unit: str, limits: Limits, notes: list[str]) -> float:
    if motion.amount is not None:
        steps = motion.amount.dimension is Dimension.STEP
        return round(motion.amount.number * limits.step_length_m, 9) if steps else motion.amount.number
    if motion.degrees:
        return motion.degrees
    name = motion.category.value
    if motion.small:
        notes.append(f"{name}: a small amount, {limits.small_factor:g} of the default of {default:g} {unit}")
        return default * limits.small_factor
    notes.append(f"{name}: no amount named, {default:g} {unit} by default")
    return default
