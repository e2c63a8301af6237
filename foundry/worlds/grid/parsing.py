"""Reads decisions from replies; never invents a decision.

`chosen`: apart from blanks around it, the text is one JSON object with the requested keys and values. Other keys are
ignored. `memory` and `reasoning` may be missing or null; so may `message`, which then means silence.

`repaired`: the fallback found one clear decision. It skips thinking, code fences, other text around the object, and
remarks on a value. It also reads nested objects, broken JSON (`foundry.worlds.mending`), lines in place of an object
(`words`), and other names of keys, actions and directions (`vocabulary`). A message such as "no message" is silence.
`memory` or `reasoning` of another type is kept as its JSON text.

`unreadable` (`truncated` if the text was cut): there is no object, an object has no decision, a key has several values,
or objects disagree. Also unreadable are a value that may continue after a cut, the prompt's own words, and an unknown
word in a decision.

Time is linear in the length of the reply.
"""

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
    """The reading of a reply to the message question.

    Attributes:
        text: the message, or None for silence or an unreadable reply.
    """

    outcome: Outcome
    text: str | None = None
    reasoning: str = ""

    @property
    def decision(self) -> tuple[object, ...]:
        """The decision; all readings of a reply must give the same decision."""
        return (self.outcome is Outcome.UNREADABLE, self.text)

    @property
    def gist(self) -> tuple[object, ...]:
        """The letters of the message; two ways to read a text must give the same letters, but may differ in quotes."""
        return (self.outcome is Outcome.UNREADABLE, _NO_LETTERS.sub("", self.text or ""))


@dataclass(frozen=True, slots=True)
class ActionReading:
    """The reading of a reply to the action question.

    Attributes:
        action: `stay` or `move`; `stay` for an unreadable reply.
        direction: `up`, `down`, `left` or `right` for a move, else None.
        memory: text to remember, or "".
    """

    outcome: Outcome
    action: str = "stay"
    direction: str | None = None
    memory: str = ""
    reasoning: str = ""

    @property
    def is_read(self) -> bool:
        """Whether the reply contains a decision."""
        return self.outcome in (Outcome.CHOSEN, Outcome.REPAIRED)

    @property
    def is_kept(self) -> bool:
        """Whether the agent will remember a text from the reply."""
        return self.is_read and bool(self.memory.strip())

    @property
    def decision(self) -> tuple[object, ...]:
        """The decision; all readings of a reply must give the same decision."""
        return (self.outcome is Outcome.UNREADABLE, self.action, self.direction)

    @property
    def gist(self) -> tuple[object, ...]:
        """The decision; two ways to read a text must give the same decision."""
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
        interpret: returns the reading of an object, or None if it contains no decision.
        blank: returns the reading of a reply without content.
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
    """Reads replies; a reading made ahead of its round is stored until that round."""

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
    """Reads the replies of an episode."""

    def __init__(self) -> None:
        self.messages = ReadOnce(read_message)
        self.actions = ReadOnce(read_action)


def _agreed(
    candidates: Iterable[dict[str, Any]], interpret: Callable[[dict[str, Any]], Reading | None]
) -> Reading | None:
    """Return the common decision of all candidates that have one; None without a decision, or if decisions differ.

    A mended candidate without content, such as the prompt's own lines, is skipped.
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
    """Yield the objects of a text that may hold a decision, and the action that the lines before them name.

    Without any object, yield all labelled values of its lines.
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
    """Return `labelled_values`; it is imported late, since its patterns take milliseconds and few replies need them."""
    from foundry.worlds.grid.words import labelled_values

    return labelled_values(text, cut=cut)


def _mending(interpret: Callable[[dict[str, Any]], Reading | None]) -> Mend:
    """Return a function that mends an object and keeps it only if its lines, read separately, agree."""

    def mend(text: str) -> Mended:
        found = mended(text, _decisive)
        reading = None if found is None else _agreed(_with_inner(found), interpret)
        lines = interpret(_said_in_lines(in_plain_marks(text), cut=False))
        agree = reading is not None and lines is not None and reading.gist == lines.gist
        return found if found is not None and agree else Mended()

    return mend


def _decisive(name: str) -> str | None:
    """Return the decisive key that a name means, or None."""
    key = key_of(name)
    return key if key in ("action", "direction", "message") else None


def _with_inner(found: dict[str, Any], depth: int = 0) -> list[dict[str, Any]]:
    """Return an object, or if it names no decision itself, its inner objects that do."""
    if depth < _DEEPEST and (not _decides(found) or _holds_inner(found)):
        within = [one for inner in _inner(found) for one in _with_inner(inner, depth + 1) if _decides(one)]
        if within:
            return within
    return [found]


def _decides(found: dict[str, Any]) -> bool:
    return any(_decisive(key) in ("action", "message") for key in found)


def _holds_inner(found: dict[str, Any]) -> bool:
    """Return whether a decisive key holds an object with a decision, as in `{"decision": {"action": ...}}`."""
    return any(_decisive(key) and _decides(one) for key, value in found.items() for one in _objects(value))


def _inner(found: dict[str, Any]) -> list[dict[str, Any]]:
    return [one for key, value in found.items() if _may_decide(key) for one in _objects(value)]


def _may_decide(key: str) -> bool:
    return key_of(key) not in ("memory", "reasoning") and not _ASIDE.search(key)


def _objects(value: object) -> list[dict[str, Any]]:
    """Return a value as a list of objects: itself, or the objects in a list."""
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
    """Return whether the text may not be an agent's message."""
    if message is not None and is_placeholder(message):
        return True
    return isinstance(found, Mended) and ("message" not in fields or is_glued(message or ""))


def interpret_action(found: dict[str, Any]) -> ActionReading | None:
    """Return the action in an object, or None if the object is about something else."""
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
"""Maximum depth of nested objects that are read."""

_ASIDE = re.compile(
    r"(?<![a-z])(?:previous|last|past|examples?|alternatives?|options?|reject\w*|consider\w*|discard\w*|if|else|others?)"
    r"(?![a-z])",
    re.IGNORECASE,
)
"""Names of keys that do not contain the present decision."""

_ASKED = frozenset(("message", "action", "direction", "memory", "reasoning"))


def fields_of(found: dict[str, Any]) -> dict[str, Any]:
    """Return the object if it has the requested keys, else an object with its values under the requested keys."""
    if found.keys() <= _ASKED:
        return found
    plain = merged([(key.strip().lower(), value) for key, value in found.items()])
    known = {key: value for key, value in plain.items() if key in _ASKED}
    meant = merged([(key, value) for name, value in plain.items() if (key := key_of(name)) and key not in known])
    if isinstance(found, Conflicting) or isinstance(plain, Conflicting) or isinstance(meant, Conflicting):
        return Conflicting({**meant, **known})
    return found if not meant and known.keys() <= found.keys() else {**meant, **known}


def _only(value: object) -> Any:
    """Return the only element of a list, or any other value unchanged."""
    return value[0] if isinstance(value, list) and len(value) == 1 else value


def _is_text(value: object) -> bool:
    return value is None or isinstance(value, str)


def text_of(value: object) -> str:
    """Return a string unchanged, null as "" and anything else as JSON, without lone surrogates."""
    if value is None:
        return ""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return without_surrogates(text)
