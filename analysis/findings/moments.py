"""Finds example moments: the first decisions in which two runs differ after the same question."""

import io
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec

from foundry.errors import RecordError
from foundry.records import NOT_JSON, Call, Outcome
from foundry.storing.matching import Numbered, numbered, place_of
from foundry.storing.store import RunFolder
from foundry.worlds.compared import Compared, Line, compared_of

MESSAGE = "message"
"""The kind of question that asks for a message, in worlds that ask for the action and the message separately."""
PROMPT, ALL_BUT_OWN_WORDS = "the same prompt", "the same prompt except for the agent's own earlier words"
"""Ways in which the prompts of two questions can count as equal."""
LONGEST_REPLY = 2_000
"""Maximum number of recorded characters of a reply."""
SHORTEST_WORDS = 12
"""Before prompts are compared, the agent's own texts of at least this number of characters are removed from them.

A shorter text is not removed, because it could also be part of another text.
"""
_READ = (Outcome.CHOSEN, Outcome.REPAIRED)
_DECODE = msgspec.json.Decoder(dict[str, Any]).decode


class Moment(msgspec.Struct, frozen=True, kw_only=True):
    """A decision that differs between two runs of one seed after the same question.

    Attributes:
        step: 1-based step.
        asked: similarity of the prompts: PROMPT, or ALL_BUT_OWN_WORDS, which ignores the agent's memory and messages.
        level_reply: reply in the level's run, cut at LONGEST_REPLY characters.
        reference_reply: reply in the reference's run, cut in the same way.
    """

    level_run: str
    reference_run: str
    seed: int
    step: int
    agent: int
    question: str
    asked: str
    level_reply: str
    reference_reply: str


@dataclass(frozen=True)
class Parting:
    """A decision that differs between two runs after the same question.

    Attributes:
        step: 1-based step.
    """

    step: int
    agent: int
    question: str
    asked: str
    replies: tuple[str, str]


def partings(
    first: RunFolder, second: RunFolder, is_sought: Callable[[str], bool] = lambda question: True
) -> Iterator[Parting]:
    """Yield the decisions that differ between two runs although the prompts were equal, earliest first.

    The search ends at the first step in which the runs have no equal prompts.

    Raises:
        RecordError: a record is damaged.
    """
    form = first.declared.form
    if form != second.declared.form:
        return
    compared = compared_of(form)
    lines = [_Lines(run) for run in (first, second)]
    for calls in zip(_by_step(first), _by_step(second), strict=False):
        shared = [key for key in calls[0] if key in calls[1]]
        differing = [key for key in shared if is_sought(key[0][2]) and _differ(key, lines, compared)]
        # Prompts are long, so those of differing decisions are compared first, and others only until two are equal.
        any_alike = False
        for key in differing:
            if asked := _asked_alike(key, calls[0][key], calls[1][key], lines):
                any_alike = True
                yield Parting(*key[0], asked, (calls[0][key].text, calls[1][key].text))
        others = set(shared) - set(differing)
        if not any_alike and not any(_asked_alike(key, calls[0][key], calls[1][key], lines) for key in others):
            return


def first_moment(level: RunFolder, reference: RunFolder, seed: int, question: str) -> Moment | None:
    """Return the first decision that differs between two runs although the prompts were equal; None if none differs.

    If `question` is MESSAGE, only messages are compared, otherwise only other decisions.

    Raises:
        RecordError: a record is damaged.
    """
    sought = partings(level, reference, lambda kind: (kind == MESSAGE) == (question == MESSAGE))
    for parting in sought:
        return Moment(
            level_run=level.id,
            reference_run=reference.id,
            seed=seed,
            step=parting.step,
            agent=parting.agent,
            question=parting.question,
            asked=parting.asked,
            level_reply=parting.replies[0][:LONGEST_REPLY],
            reference_reply=parting.replies[1][:LONGEST_REPLY],
        )
    return None


class _Lines:
    """The decisions of a run by question; each line is read when it is first needed."""

    def __init__(self, run: RunFolder) -> None:
        self._path = run.path
        self._rest = io.BytesIO(run.steps_bytes())
        self._by_place: dict[tuple[int, int], list[Line]] = {}
        self._until = 0
        self._unnoted: list[Line] = []
        self._own_words: dict[int, list[tuple[float, str]]] = {}

    def of(self, key: Numbered) -> Line | None:
        """Return the recorded decision of a question; a line without a kind answers questions of every kind."""
        (step, agent, kind), again = key
        self._read(step)
        same_kind = (line for line in self._by_place.get((step, agent), ()) if line.get("kind", kind) == kind)
        return next(itertools.islice(same_kind, again, None), None)

    def own_words(self, key: Numbered) -> list[str]:
        """Return the notes and messages that an agent wrote before a question, longest first."""
        (step, agent, kind), _ = key
        self._read(step)
        self._note()
        until = step if kind == MESSAGE else step + 0.5
        return sorted((text for at, text in self._own_words.get(agent, []) if at < until), key=len, reverse=True)

    def _read(self, step: int) -> None:
        try:
            while self._until <= step and (text := next(self._rest, None)) is not None:
                line = _DECODE(text)
                self._until = line["step"]
                self._by_place.setdefault((line["step"], line["agent"]), []).append(line)
                self._unnoted.append(line)
        except (*NOT_JSON, KeyError) as error:
            raise RecordError(f"The steps of '{self._path}' cannot be read: {error}") from error

    def _note(self) -> None:
        """Store the agents' own words: the agent sees a note from the next step on, and a message at once."""
        for line in self._unnoted:
            for text, at in ((line.get("memory"), line["step"] + 0.75), (line.get("message"), line["step"] + 0.25)):
                if isinstance(text, str) and len(text) >= SHORTEST_WORDS:
                    self._own_words.setdefault(line["agent"], []).append((at, text))
        self._unnoted.clear()


def _by_step(run: RunFolder) -> Iterator[Mapping[Numbered, Call]]:
    for _, calls in itertools.groupby(run.calls(), key=lambda call: call.step):
        yield dict(numbered(calls, place_of))


def _asked_alike(key: Numbered, call: Call, other: Call, lines: Sequence[_Lines]) -> str:
    """Return whether two prompts are equal: PROMPT, ALL_BUT_OWN_WORDS, or "" if they differ."""
    if call.messages == other.messages:
        return PROMPT
    words = [own.own_words(key) for own in lines]
    if not any(words):
        return ""
    texts = [_without(one_call.messages, own) for one_call, own in zip((call, other), words, strict=True)]
    return ALL_BUT_OWN_WORDS if texts[0] == texts[1] else ""


def _without(messages: Sequence[Mapping[str, Any]], own_words: Sequence[str]) -> list[Any]:
    contents = [str(message["content"]) for message in messages]
    for words in own_words:
        at = next((place for place, content in enumerate(contents) if words in content), None)
        if at is not None:
            contents[at] = contents[at].replace(words, "", 1)
    return [{**message, "content": content} for message, content in zip(messages, contents, strict=True)]


def _differ(key: Numbered, lines: Sequence[_Lines], compared: Compared) -> bool:
    """Return whether both decisions are readable and differ; messages differ if only one agent spoke."""
    is_message = key[0][2] == MESSAGE
    outcome = "message_outcome" if is_message else "outcome"
    first, second = lines[0].of(key), lines[1].of(key)
    if first is None or second is None:
        return False
    if any(line.get(outcome, line.get("outcome")) not in _READ for line in (first, second)):
        return False
    if is_message:
        return (first.get("message") is None) != (second.get("message") is None)
    return not compared.acts_alike(first, second)
