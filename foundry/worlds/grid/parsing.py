"""Reads decisions from replies; invents none.

`chosen`: the whole text, but for surrounding blanks, is one JSON object with the asked keys and values. Other
keys are ignored, `memory` and `reasoning` may be missing or null, and so may `message`, which is silence.

`repaired`: one decision was found by the fallback, which sees through thinking (`<think>`), code fences and
other text around the object, single quotes, Python's constants, trailing commas, raw line breaks in strings,
keys and values in another case, and a few synonyms. `memory` or `reasoning` that are no strings are kept as
their JSON text.

`unreadable` (`truncated`, when the text was cut): no object, an object without a decision in it, a key that
is given twice with different values, or several objects that disagree.

Time is linear in the length of the reply.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from foundry.records import Outcome
from foundry.texts import without_surrogates
from foundry.worlds.base import Answer, unanswered, undecided_outcome
from foundry.worlds.grid.words import understand
from foundry.worlds.replies import Conflicting, find_objects, merged, whole_object, without_thinking


@dataclass(frozen=True, slots=True)
class MessageReading:
    """What a reply to the message question says.

    Attributes:
        outcome: what became of the call.
        text: the message, or None for silence or when nothing could be read.
        reasoning: the explanation, or "".
    """

    outcome: Outcome
    text: str | None = None
    reasoning: str = ""

    @property
    def decision(self) -> tuple[object, ...]:
        """What several readings of one reply must agree on."""
        return (self.outcome is Outcome.UNREADABLE, self.text)


@dataclass(frozen=True, slots=True)
class ActionReading:
    """What a reply to the action question says.

    Attributes:
        outcome: what became of the call.
        action: `stay` or `move`; `stay` when nothing could be read.
        direction: `up`, `down`, `left` or `right` for a move, else None.
        memory: what to remember, or "".
        reasoning: the explanation, or "".
    """

    outcome: Outcome
    action: str = "stay"
    direction: str | None = None
    memory: str = ""
    reasoning: str = ""

    @property
    def decision(self) -> tuple[object, ...]:
        """What several readings of one reply must agree on."""
        return (self.outcome is Outcome.UNREADABLE, self.action, self.direction)


Reading = TypeVar("Reading", MessageReading, ActionReading)


def read_message(answer: Answer) -> MessageReading:
    """Read the reply to a message question."""
    return _read(answer, _interpret_message, MessageReading)


def read_action(answer: Answer) -> ActionReading:
    """Read the reply to an action question."""
    return _read(answer, _interpret_action, ActionReading)


def _read(
    answer: Answer,
    interpret: Callable[[dict[str, Any]], Reading | None],
    blank: Callable[[Outcome], Reading],
) -> Reading:
    """Read a reply.

    Args:
        answer: the reply.
        interpret: returns what an object says, or None when it is about something else.
        blank: returns the reading of a reply that says nothing.
    """
    if (outcome := unanswered(answer)) is not None:
        return blank(outcome)
    undecided = blank(undecided_outcome(answer))
    whole = whole_object(answer.text)
    if whole is not None:
        reading = interpret(whole)
        return undecided if reading is None or reading.outcome is Outcome.UNREADABLE else reading
    content = without_thinking(answer.text)
    if (outcome := unanswered(Answer(content, answer.ending))) is not None:
        return blank(outcome)
    readings = [reading for found in find_objects(content) if (reading := interpret(found)) is not None]
    if len({reading.decision for reading in readings}) != 1 or readings[-1].outcome is Outcome.UNREADABLE:
        return undecided
    return replace(readings[-1], outcome=Outcome.REPAIRED)


def _interpret_message(found: dict[str, Any]) -> MessageReading | None:
    fields = _fields(found)
    if isinstance(fields, Conflicting):
        return MessageReading(Outcome.UNREADABLE)
    if "message" not in fields and "reasoning" not in fields:
        return None
    message, reasoning = fields.get("message"), fields.get("reasoning")
    if not _is_text(message):
        return MessageReading(Outcome.UNREADABLE)
    exact = fields is found and _is_text(reasoning)
    said = _text(message) if message and message.strip() else None
    return MessageReading(Outcome.CHOSEN if exact else Outcome.REPAIRED, said, _text(reasoning))


def _interpret_action(found: dict[str, Any]) -> ActionReading | None:
    fields = _fields(found)
    if isinstance(fields, Conflicting):
        return ActionReading(Outcome.UNREADABLE)
    if "action" not in fields:
        return None
    asked, wanted = fields["action"], fields.get("direction")
    meant = understand(asked, wanted)
    if meant is None:
        return ActionReading(Outcome.UNREADABLE)
    memory, reasoning = fields.get("memory"), fields.get("reasoning")
    as_asked = asked == meant.action and (meant.direction is None or wanted == meant.direction)
    exact = fields is found and as_asked and _is_text(memory) and _is_text(reasoning)
    outcome = Outcome.CHOSEN if exact else Outcome.REPAIRED
    return ActionReading(outcome, meant.action, meant.direction, _text(memory), _text(reasoning))


_ASKED = frozenset(("message", "action", "direction", "memory", "reasoning"))


def _fields(found: dict[str, Any]) -> dict[str, Any]:
    """Return the object itself when its keys are as asked, else one with the keys' case and blanks mended."""
    if found.keys() <= _ASKED:
        return found
    mended = merged([(key.strip().lower(), value) for key, value in found.items()])
    known = {key: value for key, value in mended.items() if key in _ASKED}
    if isinstance(found, Conflicting) or isinstance(mended, Conflicting):
        return Conflicting(known)
    return found if known.keys() <= found.keys() else known


def _is_text(value: object) -> bool:
    return value is None or isinstance(value, str)


def _text(value: object) -> str:
    """Return a string as it is, null as "", anything else as JSON; without lone surrogates, which no file takes."""
    if value is None:
        return ""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return without_surrogates(text)
