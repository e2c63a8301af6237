"""From all motions of a text to the one command it comes down to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field, replace

from foundry.records import Outcome
from foundry.texts import without_surrogates
from foundry.worlds.camera.language.asking import read_sentence
from foundry.worlds.camera.language.command import Command, Limits, Translation, limited
from foundry.worlds.camera.language.mentions import Category, Mention
from foundry.worlds.camera.language.sentences import find_sentences
from foundry.worlds.camera.language.words import Dimension

_LONGEST_QUOTE = 80


@dataclass(slots=True)
class _Latest:
    """What is left of the motions read so far."""

    mentions: dict[Category, Mention] = field(default_factory=dict)
    overridden: Counter[Category] = field(default_factory=Counter)
    refused: int = 0
    told: int = 0
    retracting: bool = False
    ordered: bool = False

    def take(self, mentions: Iterable[Mention]) -> None:
        """Take the motions of one sentence into account."""
        mentions = [mention for mention in mentions if not self._is_retraction(mention)]
        stays = [mention for mention in mentions if mention.category is Category.STAY]
        if stays:
            self._retract()
            self.mentions = {Category.STAY: stays[-1]}
        for mention in mentions:
            if mention.told:
                self.told += 1
            elif not mention.wanted:
                self._refuse(mention)
            elif mention.category is not Category.STAY:
                self._retract()
                self.overridden[mention.category] += mention.category in self.mentions
                self.mentions[mention.category] = mention
                self.mentions.pop(Category.STAY, None)

    def _is_retraction(self, mention: Mention) -> bool:
        first_order = mention.category is Category.ORDER and not self.ordered
        self.ordered = self.ordered or first_order
        self.retracting = self.retracting or first_order or mention.category is Category.RETRACT
        return mention.category in (Category.RETRACT, Category.ORDER)

    def _retract(self) -> None:
        """Take back what was said before, now that something takes its place."""
        if self.retracting:
            self.mentions.clear()
            self.retracting = False

    def _refuse(self, mention: Mention) -> None:
        self.refused += 1
        earlier = self.mentions.get(mention.category)
        if earlier is not None and mention.direction in (earlier.direction, _ANY[mention.category]):
            del self.mentions[mention.category]


_ANY = {Category.TRANSLATE: None, Category.TURN: 0.0, Category.GAZE: 0.0}
"""The direction of a motion that is refused whatever its direction."""


def resolve(text: str, limits: Limits) -> Command:
    """Return the command in a cleaned text."""
    latest = _Latest()
    sentences = [read_sentence(sentence) for sentence in find_sentences(text)]
    at_once = any(mention.wanted and not mention.later for mentions in sentences for mention in mentions)
    for mentions in sentences:
        latest.take(mention for mention in mentions if not (at_once and mention.later))
    found, notes = latest.mentions, list[str]()
    for mention in found.values():
        notes.extend(_origin(mention, latest.overridden[mention.category]))
    command = Command(
        translate=_translation(found.get(Category.TRANSLATE), limits, notes),
        turn=_angle(found.get(Category.TURN), limits.default_turn_deg, limits.max_turn_deg, limits, notes),
        gaze=_angle(found.get(Category.GAZE), limits.default_gaze_deg, limits.max_gaze_deg, limits, notes),
        stay=Category.STAY in found,
        outcome=_outcome(found.values()),
    )
    if latest.refused:
        notes.append(f"named as not to be done: {latest.refused}")
    if latest.told:
        notes.append(f"told and not asked for: {latest.told}")
    return replace(command, notes=tuple(notes or ["no movement found"]))


def _outcome(found: Collection[Mention]) -> Outcome:
    if not found:
        return Outcome.UNREADABLE
    return Outcome.REPAIRED if any(mention.inferred for mention in found) else Outcome.CHOSEN


def _origin(mention: Mention, overridden: int) -> Iterable[str]:
    """Yield what a motion was read from, and how."""
    name = mention.category.value
    text = without_surrogates(mention.text)
    yield f"{name}: '{text if len(text) <= _LONGEST_QUOTE else text[: _LONGEST_QUOTE - 3] + '...'}'"
    yield from (f"{name}: {remark}" for remark in mention.remarks)
    if overridden:
        yield f"{name}: the latest of {overridden + 1}"


def _translation(mention: Mention | None, limits: Limits, notes: list[str]) -> Translation | None:
    if mention is None:
        return None
    asked = _asked(mention, limits.default_distance_m, "m", limits, notes)
    return Translation(mention.direction, limited("translate", asked, limits.max_distance_m, "m", notes))


def _angle(
    mention: Mention | None, default: float, largest: float | None, limits: Limits, notes: list[str]
) -> float | None:
    if mention is None:
        return None
    asked = mention.direction * abs(_asked(mention, mention.degrees or default, "degrees", limits, notes))
    return limited(mention.category.value, asked, largest, "degrees", notes) + 0.0  # no negative zero


def _asked(mention: Mention, default: float, unit: str, limits: Limits, notes: list[str]) -> float:
    """Return the amount that is asked for, metres or degrees."""
    if mention.amount is not None:
        steps = mention.amount.dimension is Dimension.STEP
        return round(mention.amount.number * limits.step_length_m, 9) if steps else mention.amount.number
    if mention.degrees:
        return mention.degrees
    name = mention.category.value
    if mention.small:
        notes.append(f"{name}: a small amount, {limits.small_factor:g} of the default of {default:g} {unit}")
        return default * limits.small_factor
    notes.append(f"{name}: no amount named, {default:g} {unit} by default")
    return default
