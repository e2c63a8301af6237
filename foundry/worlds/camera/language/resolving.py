"""From all motions of a text to the one command it comes down to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field, replace

from foundry.records import Outcome
from foundry.texts import without_surrogates
from foundry.worlds.camera.language.commands import read_sentence
from foundry.worlds.camera.language.motions import Category, Motion
from foundry.worlds.camera.language.movement import Command, Limits, Translation, limited
from foundry.worlds.camera.language.sentences import find_sentences
from foundry.worlds.camera.language.vocabulary.words import Dimension

_LONGEST_QUOTE = 80


@dataclass(slots=True)
class _Latest:
    """What is left of the motions read so far."""

    motions: dict[Category, Motion] = field(default_factory=dict)
    overridden: Counter[Category] = field(default_factory=Counter)
    refused: int = 0
    told: int = 0
    retracting: bool = False

    def take(self, motions: Iterable[Motion]) -> None:
        """Take the motions of one sentence into account."""
        motions = [motion for motion in motions if not self._is_retraction(motion)]
        stays = [motion for motion in motions if motion.category is Category.STAY]
        if stays:
            self._retract()
            self.motions = {Category.STAY: stays[-1]}
        for motion in motions:
            if motion.told:
                self.told += 1
            elif not motion.wanted:
                self._refuse(motion)
            elif motion.category is not Category.STAY:
                self._retract()
                self.overridden[motion.category] += motion.category in self.motions
                self.motions[motion.category] = motion
                self.motions.pop(Category.STAY, None)

    def _is_retraction(self, motion: Motion) -> bool:
        self.retracting = self.retracting or motion.category is Category.RETRACT
        return motion.category is Category.RETRACT

    def _retract(self) -> None:
        """Take back what was said before, now that something takes its place."""
        if self.retracting:
            self.motions.clear()
            self.retracting = False

    def _refuse(self, motion: Motion) -> None:
        self.refused += 1
        earlier = self.motions.get(motion.category)
        if earlier is not None and motion.direction in (earlier.direction, _ANY[motion.category]):
            del self.motions[motion.category]


_ANY = {Category.TRANSLATE: None, Category.TURN: 0.0, Category.GAZE: 0.0}
"""The direction of a motion that is refused whatever its direction."""


def resolve(text: str, limits: Limits) -> Command:
    """Return the command in a cleaned text."""
    latest = _Latest()
    sentences = [read_sentence(sentence) for sentence in find_sentences(text)]
    at_once = any(motion.wanted and not motion.later for motions in sentences for motion in motions)
    for motions in sentences:
        latest.take(motion for motion in motions if not (at_once and motion.later))
    found, notes = latest.motions, list[str]()
    for motion in found.values():
        notes.extend(_origin(motion, latest.overridden[motion.category]))
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


def _outcome(found: Collection[Motion]) -> Outcome:
    if not found:
        return Outcome.UNREADABLE
    return Outcome.REPAIRED if any(motion.inferred for motion in found) else Outcome.CHOSEN


def _origin(motion: Motion, overridden: int) -> Iterable[str]:
    """Yield what a motion was read from, and how."""
    name = motion.category.value
    text = without_surrogates(motion.text)
    yield f"{name}: '{text if len(text) <= _LONGEST_QUOTE else text[: _LONGEST_QUOTE - 3] + '...'}'"
    yield from (f"{name}: {remark}" for remark in motion.remarks)
    if overridden:
        yield f"{name}: the latest of {overridden + 1}"


def _translation(motion: Motion | None, limits: Limits, notes: list[str]) -> Translation | None:
    if motion is None:
        return None
    asked = _asked(motion, limits.default_distance_m, "m", limits, notes)
    return Translation(motion.direction, limited("translate", asked, limits.max_distance_m, "m", notes))


def _angle(
    motion: Motion | None, default: float, largest: float | None, limits: Limits, notes: list[str]
) -> float | None:
    if motion is None:
        return None
    asked = motion.direction * abs(_asked(motion, motion.degrees or default, "degrees", limits, notes))
    return limited(motion.category.value, asked, largest, "degrees", notes) + 0.0  # no negative zero


def _asked(motion: Motion, default: float, unit: str, limits: Limits, notes: list[str]) -> float:
    """Return the amount that is asked for, metres or degrees."""
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
