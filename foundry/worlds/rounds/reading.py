"""Reads decisions and talk from replies, and never guesses a decision.

A reply counts as chosen if it has the requested form. This form is a decision alone, such as "go", or a JSON object
whose key `action` (or the kind of question) has a decision alone as its value. A reply to a question that asks for a
message has the requested form if it is a JSON object with a message, or a text without any JSON object.

A reply counts as repaired if it has one clear decision in another form. The decision may follow thinking, or be in a
code fence, between other text or in broken JSON. The decision may also be a line such as "Action: go", or a sentence
such as "I will go." if foundry knows all its words.

Any other reply counts as unreadable (if the text was cut, as truncated), for example an illegal or a contradictory
decision. An unknown word may revoke a decision, so it makes a text unreadable: "I will not go" decides nothing.
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from foundry.declared import Actions
from foundry.records import Outcome
from foundry.texts import without_surrogates
from foundry.worlds.base import LENGTH, Answer, Reading, unanswered, undecided_outcome
from foundry.worlds.grid.parsing import read_message
from foundry.worlds.grid.words import is_placeholder, is_silence, key_of
from foundry.worlds.mending import Mended, in_plain_marks, mended
from foundry.worlds.replies import Conflicting, find_objects, whole_object, without_thinking
from foundry.worlds.rounds.decided import Decided, decided_text, decided_value, is_exact

ACTION, MESSAGE = "action", "message"
_DEEPEST = 4
"""Maximum depth of nested objects that are read."""
_MOST_LINES = 8
"""Maximum number of lines that name a decision; a text with more such lines contains no clear decision."""
_FURTHER = ("choice", "my choice", "final choice", "answer", "my answer", "final answer")
_ASIDE = re.compile(
    r"(?<![a-z])(?:previous|last|past|examples?|alternatives?|options?|reject\w*|consider\w*|if|else|others?|memor\w*"
    r"|reason\w*)(?![a-z])",
    re.IGNORECASE,
)
"""Names of keys and lines that contain a past, possible or rejected decision, such as the last action."""
_LINE = re.compile(
    r"^[ \t>*•#\d.)_`\"'“-]{0,12}+((?:(?:my|the|final)[ ])?[^\W\d][\w ]{0,30}?)[ \t*_`\"'”]{0,6}+"
    r"[:：=](?!=)[\s*_]*+(.*)$",
    re.MULTILINE,
)
_PAIR = re.compile(r"""["'“”]?([^\W\d][\w ]{0,39})["'“”]?\s*+[:：]\s*+["'“”]?([^"'“”,{}\n]*+)""")
_TAG = re.compile(r"<([a-zA-Z_]{1,30})>([^<>]{0,200})</\1>")


def read_talk(answer: Answer) -> Reading:
    """Read the message in the reply to a question that asks for a message."""
    message = read_message(answer)
    if message.outcome is not Outcome.UNREADABLE:
        return Reading(message.outcome, message=message.text)
    text = without_thinking(answer.text).strip()
    if "{" in text or is_placeholder(text):
        return Reading(Outcome.UNREADABLE)
    outcome = Outcome.CHOSEN if text == answer.text.strip() else Outcome.REPAIRED
    return Reading(outcome, message=None if is_silence(text) else without_surrogates(text))


def read_decision(answer: Answer, actions: Actions, kind: str) -> Reading:
    """Read the decision in the reply to a question that allows these actions."""
    if (outcome := unanswered(answer)) is not None:
        return Reading(outcome)
    return _Reader(actions, kind).read(answer)


@dataclass(frozen=True)
class _Reader:
    actions: Actions
    kind: str

    def read(self, answer: Answer) -> Reading:
        undecided = Reading(undecided_outcome(answer))
        whole = whole_object(answer.text)
        if whole is not None and self._is_as_asked(whole) and (reading := self._of(whole)) is not None:
            return replace(reading, outcome=Outcome.CHOSEN)
        if is_exact(answer.text.strip(), self.actions) and answer.ending != LENGTH:
            return Reading(Outcome.CHOSEN, answer.text.strip())
        content = answer.text if whole is not None else without_thinking(answer.text)
        if (outcome := unanswered(Answer(content, answer.ending))) is not None:
            return Reading(outcome)
        objects = find_objects(content, self._mended)
        reading = self._in_objects(objects, content) if objects else self._in_lines(content, answer)
        return undecided if reading is None else replace(reading, outcome=self._outcome(reading, answer))

    def _outcome(self, reading: Reading, answer: Answer) -> Outcome:
        return Outcome.CHOSEN if answer.text.strip() == str(reading.action) else Outcome.REPAIRED

    def _is_as_asked(self, fields: Mapping[str, Any]) -> bool:
        """Return whether an object has exactly one key for decisions, and the value of this key is a legal decision."""
        named = [key for key in fields if self._decides(key)]
        if isinstance(fields, Conflicting):
            return False
        return len(named) == 1 and named[0] in (ACTION, self.kind) and is_exact(fields[named[0]], self.actions)

    def _in_objects(self, objects: Sequence[dict[str, Any]], content: str) -> Reading | None:
        """Return the decision if all objects of a text, and the lines before them, give the same one; else None."""
        decisions = [reading for inner in objects for reading in self._within(inner)]
        readings = [decision for decision in decisions if decision is not None]
        if not readings or len(readings) < len(decisions):
            return None
        before = {self._value(value) for value in self._lines(content.partition("{")[0])}
        return readings[-1] if {reading.action for reading in readings} | before == {readings[-1].action} else None

    def _within(self, fields: dict[str, Any], depth: int = 0) -> Iterator[Reading | None]:
        """Yield the decision of an object, else the decisions of its inner objects; None for an uncertain decision."""
        if isinstance(fields, Conflicting):
            yield None
        elif any(self._decides(key) and not isinstance(value, dict) for key, value in fields.items()):
            yield self._of(fields)
        elif depth < _DEEPEST:
            for key, value in fields.items():
                if isinstance(value, dict) and not _ASIDE.search(key):
                    yield from self._within(value, depth + 1)

    def _of(self, fields: Mapping[str, Any]) -> Reading | None:
        """Return the decision that the keys of an object name; None if it is uncertain, or the keys disagree."""
        decisions = {self._value(value) for key, value in fields.items() if self._decides(key)}
        if len(decisions) != 1 or None in decisions:
            return None
        message = fields.get(MESSAGE)
        spoken = isinstance(message, str) and not is_silence(message) and not is_placeholder(message)
        return Reading(Outcome.REPAIRED, decisions.pop(), without_surrogates(message) if spoken and message else None)

    def _mended(self, text: str) -> dict[str, Any]:
        """Return the mended object of a text, but only if the text's lines, read one by one, give the same decision."""
        whole = mended(text, lambda name: ACTION if self._decides(name) else None)
        reading = None if whole is None else self._of(whole)
        pairs = _PAIR.findall(in_plain_marks(text))
        lines = {self._value(value.strip()) for key, value in pairs if self._decides(key)}
        return whole if whole is not None and reading is not None and lines == {reading.action} else Mended()

    def _in_lines(self, content: str, answer: Answer) -> Reading | None:
        """Return the decision from lines such as "Action: go"; if there are none, read the whole text."""
        if answer.ending == LENGTH:  # the text may be incomplete
            return None
        named = list(self._lines(content))
        if not named:
            decided = decided_text(content, self.actions, self.kind)
        else:
            values = {self._value(value) for value in named}
            decided = values.pop() if len(values) == 1 and len(named) <= _MOST_LINES else None
        return None if decided is None else Reading(Outcome.REPAIRED, decided)

    def _lines(self, text: str) -> Iterator[str]:
        """Yield the values after words that announce a decision, such as "go" in the line "Action: go"."""
        for match in (*_TAG.finditer(text), *_LINE.finditer(_TAG.sub("", text))):
            if self._decides(match[1].strip()):
                yield match[2].strip().rstrip(",").strip(" \"'")

    def _value(self, value: object) -> Decided | None:
        return decided_value(value, self.actions, self.kind)

    def _decides(self, name: str) -> bool:
        plain = name.strip().casefold().replace("_", " ")
        return plain == self.kind.replace("_", " ") or plain in _FURTHER or key_of(name) == ACTION


MOST_NUMBERS = 1001
"""Length of the longest range of whole numbers that gets a reply for each number."""
SPACED = 101
"""Number of evenly spaced numbers with a sample reply if a range is longer than that or has real numbers."""
SILENCE = json.dumps({MESSAGE: None})


@lru_cache(maxsize=4096)
def options_of(actions: Actions | None) -> tuple[str, ...]:
    """Return a reply for each action, or for evenly spaced numbers of a long range; for talk, the silent reply."""
    if actions is None:
        return (SILENCE,)
    return tuple(map(deciding, actions.labels or _numbers(actions)))


@lru_cache(maxsize=4096)
def idle_of(actions: Actions | None) -> str | None:
    """Return the reply that does nothing, or None if there is none."""
    if actions is None:
        return SILENCE
    return None if actions.idle is None else deciding(actions.idle)


def deciding(action: str | float) -> str:
    """Return the reply that chooses an action."""
    return json.dumps({ACTION: action}, ensure_ascii=False)


def _numbers(actions: Actions) -> list[float]:
    """Return the numbers for which a sample reply is made; none if the range has no lower or no upper end."""
    if actions.low is None or actions.high is None:
        return []
    if not actions.whole:
        return [float(number) for number in np.linspace(actions.low, actions.high, SPACED)]
    first, last = int(np.ceil(actions.low)), int(np.floor(actions.high))
    if last - first < MOST_NUMBERS:
        return list(range(first, last + 1))
    return sorted({round(number) for number in np.linspace(first, last, SPACED).tolist()})
