"""Reads decisions from replies; invents none.

`chosen`: the whole text, but for surrounding blanks, is one JSON object with the asked keys and values. Other
keys are ignored, `memory` and `reasoning` may be missing or null, and so may `message`, which is silence.

`repaired`: one decision that no person would doubt was found by the fallback, which sees through thinking, code
fences and other text around the object, objects within objects, broken JSON (`foundry.worlds.mending`), lines instead
of it (`words`), other names of keys, actions and directions (`vocabulary`) and remarks on them. A message that says
there is none is silence. `memory` or `reasoning` that are no strings are kept as their JSON text.

`unreadable` (`truncated`, when the text was cut): no object, an object without a decision in it, a key that
is given twice with different values, several objects that disagree, a value that may go on after the end of a cut
text, the prompt's own words, or anything in a decision that is not known.

Time is linear in the length of the reply.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

from foundry.records import Outcome
from foundry.texts import without_surrogates
from foundry.worlds.base import LENGTH, Answer, unanswered, undecided_outcome
from foundry.worlds.grid.words import is_placeholder, is_silence, key_of, understand
from foundry.worlds.mending import Mended, in_plain_marks, is_glued, mended
from foundry.worlds.replies import Conflicting, Mend, find_objects, merged, whole_object, without_thinking


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

    @property
    def gist(self) -> tuple[object, ...]:
        """What two ways to read one text must agree on: the letters, whatever stands for quotes and line breaks."""
        return (self.outcome is Outcome.UNREADABLE, _NO_LETTERS.sub("", self.text or ""))


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
    def is_read(self) -> bool:
        """Whether a decision could be read."""
        return self.outcome in (Outcome.CHOSEN, Outcome.REPAIRED)

    @property
    def is_kept(self) -> bool:
        """Whether there is something that the agent remembers from now on."""
        return self.is_read and bool(self.memory.strip())

    @property
    def decision(self) -> tuple[object, ...]:
        """What several readings of one reply must agree on."""
        return (self.outcome is Outcome.UNREADABLE, self.action, self.direction)

    @property
    def gist(self) -> tuple[object, ...]:
        """What two ways to read one text must agree on."""
        return self.decision


Reading = TypeVar("Reading", MessageReading, ActionReading)


def read_message(answer: Answer) -> MessageReading:
    """Read the reply to a message question."""
    return read_as(answer, _interpret_message, MessageReading)


def read_action(answer: Answer) -> ActionReading:
    """Read the reply to an action question."""
    return read_as(answer, interpret_action, ActionReading)


def read_as(
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
    if whole is not None and _with_inner(whole)[0] is whole and (reading := interpret(whole)) is not None:
        return undecided if reading.outcome is Outcome.UNREADABLE else reading
    content = without_thinking(answer.text) if whole is None else answer.text
    if (outcome := unanswered(Answer(content, answer.ending))) is not None:
        return blank(outcome)
    reading = _agreed(_candidates(content, answer, interpret), interpret)
    return undecided if reading is None else replace(reading, outcome=Outcome.REPAIRED)


class ReadOnce(Generic[Reading]):
    """Reads replies; what was read ahead of its round is kept until the round comes."""

    def __init__(self, read: Callable[[Answer], Reading]) -> None:
        self._read: Callable[[Answer], Reading] = read
        self._kept: dict[Answer, Reading] = {}

    def ahead(self, answer: Answer) -> Reading:
        """Read a reply before its round."""
        reading = self._kept[answer] = self._read(answer)
        return reading

    def in_round(self, answer: Answer) -> Reading:
        """Read a reply in its round."""
        kept = self._kept.pop(answer, None)
        return self._read(answer) if kept is None else kept


class Readings:
    """Reads the replies of an episode.

    Attributes:
        messages: reads those to message questions.
        actions: reads those to action questions.
    """

    def __init__(self) -> None:
        self.messages = ReadOnce(read_message)
        self.actions = ReadOnce(read_action)


def _agreed(
    candidates: Iterable[dict[str, Any]], interpret: Callable[[dict[str, Any]], Reading | None]
) -> Reading | None:
    """Return the decision of all candidates that hold one; None when there is none, or more than one.

    One that had to be mended, and says nothing even so, is passed over: the prompt's own lines, for example.
    """
    readings = [
        reading
        for found in candidates
        if (reading := interpret(found)) is not None
        and not (isinstance(found, Mended) and reading.outcome is Outcome.UNREADABLE)
    ]
    if len({reading.decision for reading in readings}) != 1 or readings[-1].outcome is Outcome.UNREADABLE:
        return None
    return readings[-1]


def _candidates(
    content: str, answer: Answer, interpret: Callable[[dict[str, Any]], Reading | None]
) -> Iterator[dict[str, Any]]:
    """Yield the objects of a text, or those within them that decide, and the action that the lines before them name.

    Where there is no object, all that its lines say.
    """
    objects = find_objects(content, _mending(interpret))
    for found in objects:
        yield from _with_inner(found)
    if not objects:
        yield _said_in_lines(content, cut=answer.ending == LENGTH)
        return
    before = _said_in_lines(content.partition("{")[0], cut=False)
    if "action" in before and not isinstance(before, Conflicting):
        yield Mended(before)


def _said_in_lines(text: str, *, cut: bool) -> dict[str, Any]:
    """Return `labelled_values`, whose patterns take milliseconds to make: most replies never need them."""
    from foundry.worlds.grid.words import labelled_values

    return labelled_values(text, cut=cut)


def _mending(interpret: Callable[[dict[str, Any]], Reading | None]) -> Mend:
    """Return what mends an object, and keeps it only when its lines, read by themselves, say the same."""

    def mend(text: str) -> Mended:
        found = mended(text, _decisive)
        reading = None if found is None else _agreed(_with_inner(found), interpret)
        lines = interpret(_said_in_lines(in_plain_marks(text), cut=False))
        agree = reading is not None and lines is not None and reading.gist == lines.gist
        return found if found is not None and agree else Mended()

    return mend


def _decisive(name: str) -> str | None:
    """Return which of the keys that decide is meant by a name."""
    key = key_of(name)
    return key if key in ("action", "direction", "message") else None


def _with_inner(found: dict[str, Any], depth: int = 0) -> list[dict[str, Any]]:
    """Return an object, or in its place those within it that name a decision, where it does not itself."""
    if depth < _DEEPEST and (not _decides(found) or _holds_inner(found)):
        within = [one for inner in _inner(found) for one in _with_inner(inner, depth + 1) if _decides(one)]
        if within:
            return within
    return [found]


def _decides(found: dict[str, Any]) -> bool:
    return any(_decisive(key) in ("action", "message") for key in found)


def _holds_inner(found: dict[str, Any]) -> bool:
    """Tell whether what stands for the decision is an object that names one, as in `{"decision": {"action": ...}}`."""
    return any(_decisive(key) and _decides(one) for key, value in found.items() for one in _objects(value))


def _inner(found: dict[str, Any]) -> list[dict[str, Any]]:
    return [one for key, value in found.items() if _may_decide(key) for one in _objects(value)]


def _may_decide(key: str) -> bool:
    return key_of(key) not in ("memory", "reasoning") and not _ASIDE.search(key)


def _objects(value: object) -> list[dict[str, Any]]:
    """Return the object that a value is, or those in a list."""
    return [one for one in (value if isinstance(value, list) else [value]) if isinstance(one, dict)]


def _interpret_message(found: dict[str, Any]) -> MessageReading | None:
    fields = fields_of(found)
    if isinstance(fields, Conflicting):
        return MessageReading(Outcome.UNREADABLE)
    if "message" not in fields and ("reasoning" not in fields or "action" in fields):
        return None
    message, reasoning = _only(fields.get("message")), fields.get("reasoning")
    if not _is_text(message) or _is_doubtful(found, fields, message):
        return MessageReading(Outcome.UNREADABLE)
    silent = bool(message and message.strip()) and is_silence(message)
    exact = fields is found and not silent and message is fields.get("message") and _is_text(reasoning)
    said = None if silent or not message or not message.strip() else text_of(message)
    return MessageReading(Outcome.CHOSEN if exact else Outcome.REPAIRED, said, text_of(reasoning))


def _is_doubtful(found: dict[str, Any], fields: dict[str, Any], message: str | None) -> bool:
    """Tell whether nobody may have said this."""
    if message is not None and is_placeholder(message):
        return True
    return isinstance(found, Mended) and ("message" not in fields or is_glued(message or ""))


def interpret_action(found: dict[str, Any]) -> ActionReading | None:
    """Return what an object says about staying or moving; None where it is about something else."""
    fields = fields_of(found)
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
    return ActionReading(outcome, meant.action, meant.direction, text_of(memory), text_of(reasoning))


_NO_LETTERS = re.compile(r"[\W_]+")
_DEEPEST = 4
"""Objects within objects that are looked into."""

_ASIDE = re.compile(
    r"(?<![a-z])(?:previous|last|past|examples?|alternatives?|options?|reject\w*|consider\w*|discard\w*|if|else|others?)"
    r"(?![a-z])",
    re.IGNORECASE,
)
"""Names of what holds no decision of now."""

_ASKED = frozenset(("message", "action", "direction", "memory", "reasoning"))


def fields_of(found: dict[str, Any]) -> dict[str, Any]:
    """Return the object itself when its keys are as asked, else one with the keys as they are asked for."""
    if found.keys() <= _ASKED:
        return found
    plain = merged([(key.strip().lower(), value) for key, value in found.items()])
    known = {key: value for key, value in plain.items() if key in _ASKED}
    meant = merged([(key, value) for name, value in plain.items() if (key := key_of(name)) and key not in known])
    if isinstance(found, Conflicting) or isinstance(plain, Conflicting) or isinstance(meant, Conflicting):
        return Conflicting({**meant, **known})
    return found if not meant and known.keys() <= found.keys() else {**meant, **known}


def _only(value: object) -> Any:
    """Return the only text of a list, any other value as it is."""
    return value[0] if isinstance(value, list) and len(value) == 1 else value


def _is_text(value: object) -> bool:
    return value is None or isinstance(value, str)


def text_of(value: object) -> str:
    """Return a string as it is, null as "", anything else as JSON; without lone surrogates, which no file takes."""
    if value is None:
        return ""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return without_surrogates(text)
