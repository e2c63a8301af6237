"""Reads decisions from replies; never invents a decision.

A reply counts as chosen if the text, apart from blanks, is one JSON object with the requested keys and values. Keys
that the prompt does not request are ignored. The keys for the memory and the reasoning may be missing, or their values
null. If the message is missing or null, the agent is silent.

A reply counts as repaired if it contains one clear decision in another form. The reader skips thinking, code fences,
text around the object, and remarks on a value. The reader understands nested objects, broken JSON
(`foundry.worlds.mending`), and lines such as "action: stay" instead of an object. The reader knows other names of keys,
actions and directions (`words`). A message such as "no message" means silence. A memory or reasoning that is not a text
is kept as JSON.

A reply counts as unreadable (or as truncated, if the text was cut) in three cases: it has no decision, a key has
several values, or objects disagree. A decision is also unreadable if it may continue after the cut, copies the prompt's
placeholder, or contains an unknown word.

The time to read a reply is proportional to the length of the reply.
"""

import json
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, TypeVar

from foundry.records import Outcome
from foundry.texts import without_surrogates
from foundry.worlds.base import LENGTH, Answer, unanswered, undecided_outcome
from foundry.worlds.grid.words import is_placeholder, is_silence, key_of, labelled_values, understand
from foundry.worlds.mending import Mended, in_plain_marks, is_glued, mended
from foundry.worlds.replies import Conflicting, Mend, find_objects, merged, whole_object, without_thinking


@dataclass(frozen=True, slots=True)
class MessageReading:
    """The message and the outcome that were read from a reply to the message question.

    Attributes:
        text: the message, or None for silence or an unreadable reply.
    """

    outcome: Outcome
    text: str | None = None
    reasoning: str = ""

    @property
    def decision(self) -> tuple[object, ...]:
        """If a reply contains several objects, these values must be the same in each of them."""
        return (self.outcome is Outcome.UNREADABLE, self.text)

    @property
    def gist(self) -> tuple[object, ...]:
        """The message's letters and digits alone; they must be the same in a mended object and in its text."""
        return (self.outcome is Outcome.UNREADABLE, _NO_LETTERS.sub("", self.text or ""))


@dataclass(frozen=True, slots=True)
class ActionReading:
    """The decision and the outcome that were read from a reply to the action question.

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
        """True if the reply gives the agent a text to remember."""
        return self.is_read and bool(self.memory.strip())

    @property
    def decision(self) -> tuple[object, ...]:
        """If a reply contains several objects, these values must be the same in each of them."""
        return (self.outcome is Outcome.UNREADABLE, self.action, self.direction)

    @property
    def gist(self) -> tuple[object, ...]:
        """These values must be the same in a mended object and in the lines of its text, read one by one."""
        return self.decision


Reading = TypeVar("Reading", MessageReading, ActionReading)

_REMEMBERED = 4096
"""Number of cached readings, since a reply to a question that was asked early is read again in its own step."""


@lru_cache(maxsize=_REMEMBERED)
def read_message(answer: Answer) -> MessageReading:
    """Read the reply to a message question."""
    return read_as(answer, _interpret_message, MessageReading)


@lru_cache(maxsize=_REMEMBERED)
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
        interpret: returns the reading of an object, or None if the object contains no decision.
        blank: returns the reading of a reply without a decision, given its outcome.
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


def _agreed(
    candidates: Iterable[dict[str, Any]], interpret: Callable[[dict[str, Any]], Reading | None]
) -> Reading | None:
    """Return the decision in several objects; None if no object has a decision, or if decisions differ.

    A mended candidate with an unreadable decision, such as a copy of the prompt's placeholder, is skipped.
    """
    readings = [
        reading
        for candidate in candidates
        if (reading := interpret(candidate)) is not None
        and not (isinstance(candidate, Mended) and reading.outcome is Outcome.UNREADABLE)
    ]
    if len({reading.decision for reading in readings}) != 1 or readings[-1].outcome is Outcome.UNREADABLE:
        return None
    return readings[-1]


def _candidates(
    content: str, answer: Answer, interpret: Callable[[dict[str, Any]], Reading | None]
) -> Iterator[dict[str, Any]]:
    """Yield a text's JSON objects that may hold a decision, and the values in the lines before the first object.

    Lines before an object count only if they name an action. If there is no object, yield the values in all lines.
    """
    objects = find_objects(content, _mending(interpret))
    for fields in objects:
        yield from _with_inner(fields)
    if not objects:
        yield labelled_values(content, cut=answer.ending == LENGTH)
        return
    before = labelled_values(content.partition("{")[0], cut=False)
    if "action" in before and not isinstance(before, Conflicting):
        yield Mended(before)


def _mending(interpret: Callable[[dict[str, Any]], Reading | None]) -> Mend:
    """Return a function that mends a broken object, unless lines such as "action: stay" in it decide otherwise."""

    def mend(text: str) -> Mended:
        value = mended(text, _decisive)
        reading = None if value is None else _agreed(_with_inner(value), interpret)
        lines = interpret(labelled_values(in_plain_marks(text), cut=False))
        agree = reading is not None and lines is not None and reading.gist == lines.gist
        return value if value is not None and agree else Mended()

    return mend


def _decisive(name: str) -> str | None:
    """Return the requested key that a name means, such as "action"; None for names of keys without a decision."""
    key = key_of(name)
    return key if key in ("action", "direction", "message") else None


def _with_inner(fields: dict[str, Any], depth: int = 0) -> list[dict[str, Any]]:
    """Return the objects inside this object that contain a decision; without such objects, return this object.

    Inner objects are read only if the outer one has no decision, or has an object in the place of a decision.
    """
    if depth < _DEEPEST and (not _decides(fields) or _holds_inner(fields)):
        within = [
            candidate for inner in _inner(fields) for candidate in _with_inner(inner, depth + 1) if _decides(candidate)
        ]
        if within:
            return within
    return [fields]


def _decides(fields: dict[str, Any]) -> bool:
    return any(_decisive(key) in ("action", "message") for key in fields)


def _holds_inner(fields: dict[str, Any]) -> bool:
    """Return whether the value of a decision's key is itself an object, as in `{"decision": {"action": ...}}`."""
    return any(_decisive(key) and _decides(inner) for key, value in fields.items() for inner in _objects(value))


def _inner(fields: dict[str, Any]) -> list[dict[str, Any]]:
    return [inner for key, value in fields.items() if _may_decide(key) for inner in _objects(value)]


def _may_decide(key: str) -> bool:
    return key_of(key) not in ("memory", "reasoning") and not _ASIDE.search(key)


def _objects(value: object) -> list[dict[str, Any]]:
    """Return the JSON objects in a list; for a single object, a list with this object."""
    return [item for item in (value if isinstance(value, list) else [value]) if isinstance(item, dict)]


def _interpret_message(candidate: dict[str, Any]) -> MessageReading | None:
    fields = fields_of(candidate)
    if isinstance(fields, Conflicting):
        return MessageReading(Outcome.UNREADABLE)
    if "message" not in fields and ("reasoning" not in fields or "action" in fields):
        return None
    message, reasoning = _only(fields.get("message")), fields.get("reasoning")
    if not _is_text(message) or _is_doubtful(candidate, fields, message):
        return MessageReading(Outcome.UNREADABLE)
    silent = bool(message and message.strip()) and is_silence(message)
    exact = fields is candidate and not silent and message is fields.get("message") and _is_text(reasoning)
    said = None if silent or not message or not message.strip() else text_of(message)
    return MessageReading(Outcome.CHOSEN if exact else Outcome.REPAIRED, said, text_of(reasoning))


def _is_doubtful(candidate: dict[str, Any], fields: dict[str, Any], message: str | None) -> bool:
    """Return whether a message may be no message of the agent, but a copied placeholder or badly mended JSON."""
    if message is not None and is_placeholder(message):
        return True
    return isinstance(candidate, Mended) and ("message" not in fields or is_glued(message or ""))


def interpret_action(candidate: dict[str, Any]) -> ActionReading | None:
    """Return the action in an object, or None if the object has no action."""
    fields = fields_of(candidate)
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
    exact = fields is candidate and as_asked and _is_text(memory) and _is_text(reasoning)
    outcome = Outcome.CHOSEN if exact else Outcome.REPAIRED
    return ActionReading(outcome, meant.action, meant.direction, text_of(memory), text_of(reasoning))


_NO_LETTERS = re.compile(r"[\W_]+")
_DEEPEST = 4
"""Maximum depth at which nested objects are read."""

_ASIDE = re.compile(
    r"(?<![a-z])(?:previous|last|past|examples?|alternatives?|options?|reject\w*|consider\w*|discard\w*|if|else|others?)"
    r"(?![a-z])",
    re.IGNORECASE,
)
"""Matches a key whose value is a past, possible or rejected decision, such as `previous_action`."""

_ASKED = frozenset(("message", "action", "direction", "memory", "reasoning"))


def fields_of(candidate: dict[str, Any]) -> dict[str, Any]:
    """Return an object with requested keys only: other names, such as "move" for "action", are replaced."""
    if candidate.keys() <= _ASKED:
        return candidate
    plain = merged([(key.strip().lower(), value) for key, value in candidate.items()])
    known = {key: value for key, value in plain.items() if key in _ASKED}
    meant = merged([(key, value) for name, value in plain.items() if (key := key_of(name)) and key not in known])
    if isinstance(candidate, Conflicting) or isinstance(plain, Conflicting) or isinstance(meant, Conflicting):
        return Conflicting({**meant, **known})
    return candidate if not meant and known.keys() <= candidate.keys() else {**meant, **known}


def _only(value: object) -> Any:
    """Return the only element of a list, or any other value unchanged."""
    return value[0] if isinstance(value, list) and len(value) == 1 else value


def _is_text(value: object) -> bool:
    return value is None or isinstance(value, str)


def text_of(value: object) -> str:
    """Convert a value to text: None to "", and other values to JSON; remove lone surrogates."""
    if value is None:
        return ""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return without_surrogates(text)
