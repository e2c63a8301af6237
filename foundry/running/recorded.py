"""Answers questions from the log of calls of a run, and finds the first difference from recorded questions."""

import asyncio
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from os.path import commonprefix
from typing import Any

import msgspec

from foundry.episode import Asker, Asks
from foundry.errors import RecordError
from foundry.expansion import calls_seed
from foundry.models.base import Reply, Request, RequestKeys, Source, logged, there
from foundry.prompts.prompt import Prompt
from foundry.records import Call, Origin
from foundry.running.build import build
from foundry.running.replayed import reply_of
from foundry.storing.matching import place_of
from foundry.storing.store import SweepFolder, read_calls
from foundry.worlds.base import Question, QuestionKey

CALLS = "calls.jsonl.zst"
NOTHING = "nothing"
_BEFORE, _LONGEST = 24, 72
"""Number of characters that are shown of a long line that differs: before the difference, and in all."""


@dataclass(frozen=True)
class Difference:
    """The first place where a recorded file differs from the result of a replay now.

    Attributes:
        number: line of the file, from 1; None if the file has no lines.
        field: path of the key in the line, such as "pose.x"; "" for the whole line.
        now: the value in the replay.
        place: step, agent and kind of the question, if the line belongs to a question.
    """

    file: str
    number: int | None
    field: str
    recorded: Any
    now: Any
    place: tuple[int, int, str] | None = None

    def where(self) -> str:
        """Return the file, the line, the question and the key."""
        where = self.file if self.number is None else f"{self.file} line {self.number}"
        if self.place is not None:
            step, agent, kind = self.place
            where += f" (step {step}, agent {agent}, {kind})"
        return where + (f": {self.field}" if self.field else "")

    def line(self) -> str:
        """Return the difference in one line."""
        recorded, now = excerpts(self.recorded, self.now)
        return f"{self.where()}: recorded {recorded}, now {now}"


def first_difference(recorded: Any, now: Any, path: str = "") -> tuple[str, Any, Any] | None:
    """Return the path of the first value that differs, in the order of keys, and both values; None if all are equal."""
    if isinstance(recorded, Mapping) and isinstance(now, Mapping):
        for key in [*recorded, *(key for key in now if key not in recorded)]:
            inner = f"{path}.{key}" if path else str(key)
            difference = first_difference(recorded.get(key, NOTHING), now.get(key, NOTHING), inner)
            if difference is not None:
                return difference
        return None
    if isinstance(recorded, list | tuple) and isinstance(now, list | tuple):
        for number in range(max(len(recorded), len(now))):
            then, fresh = (part[number] if number < len(part) else NOTHING for part in (recorded, now))
            difference = first_difference(then, fresh, f"{path}[{number}]")
            if difference is not None:
                return difference
        return None
    same = recorded == now and isinstance(recorded, bool) == isinstance(now, bool)
    return None if same else (path, recorded, now)


def excerpts(first: Any, other: Any) -> tuple[str, str]:
    """Return two different values as short texts, which show the first character that differs."""
    if not (isinstance(first, str) and isinstance(other, str)):
        return _short(repr(first)), _short(repr(other))
    start = max(0, len(commonprefix([first, other])) - _BEFORE)
    return _excerpt(first, start), _excerpt(other, start)


def _excerpt(text: str, start: int) -> str:
    shown = repr(text[start : start + _LONGEST])
    return f"{'...' if start else ''}{shown}{'...' if start + _LONGEST < len(text) else ''}"


def _short(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


class Departed(RecordError):
    """The replayed episode differs from the recorded one."""

    def __init__(self, difference: Difference) -> None:
        super().__init__(difference.line())
        self.difference = difference


class NotRecorded(RecordError):
    """The replayed episode asks a question that is not in the log of calls."""

    def __init__(self, place: QuestionKey) -> None:
        step, agent, kind = place
        super().__init__(f"no answer to the {kind} question of agent {agent} at step {step} is recorded")
        self.place = place


@dataclass(frozen=True)
class Wording:
    """The prompt and the sampling seed with which a part of a run's questions were asked: those before a certain step.

    Attributes:
        before: the first step with another wording; None if it is valid until the end of the run.
    """

    before: int | None
    prompt: Prompt
    seed: int


def past_wordings(config: Mapping[str, Any]) -> list[Wording]:
    """Return the prompts and seeds of the questions before the fork; [] if the run is no fork."""
    past = config["fork"]["past"] if "fork" in config else []
    return [Wording(part["before"], build(part["prompt"]), part["seed"]) for part in past]


def wordings(config: Mapping[str, Any]) -> list[Wording]:
    """Return the prompts and sampling seeds of a run, in the order of steps. Only a fork can have several prompts."""
    return [*past_wordings(config), Wording(None, build(config["prompt"]), calls_seed(config))]


class RecordedAsker:
    """Answers the questions of a run from its log of calls, and checks that each question equals the recorded one.

    Attributes:
        used: number of answers that were given.
    """

    def __init__(self, calls: Iterable[Call], asked: Sequence[Wording]) -> None:
        self.calls = list(calls)
        self._calls: dict[QuestionKey, deque[tuple[int, Call]]] = {}
        for number, call in enumerate(self.calls, start=1):
            self._calls.setdefault(place_of(call), deque()).append((number, call))
        self._asked_for: dict[tuple[QuestionKey, str], Call] = {}
        self._asked = asked
        self._keys: list[tuple[Source, RequestKeys]] = []
        self.used = 0

    @property
    def recorded(self) -> int:
        """Number of calls in the log."""
        return len(self.calls)

    def request(self, question: Question) -> Request:
        """Return the request for a question, if it equals the recorded request.

        Raises:
            NotRecorded: the log does not contain the question.
            Departed: the recorded request has other words or another seed.
        """
        place = question.asked
        if not self._calls.get(place):
            raise NotRecorded(place)
        number, call = self._calls[place].popleft()  # an agent may be asked a question several times
        wording = next(wording for wording in self._asked if wording.before is None or question.step < wording.before)
        messages = wording.prompt.render(question)
        now = {
            "seed": question.sampling_seed(wording.seed),
            "messages": [logged(message) for message in messages],
            "key": "",
        }
        now["key"] = self._keys_of(call).key(messages, call.seed)
        then = {"seed": call.seed, "messages": call.messages, "key": call.key}
        difference = first_difference(then, now)
        if difference is not None:
            raise Departed(Difference(CALLS, number, *difference, place=place))
        self._asked_for[place, call.key] = call
        return Request(
            messages=messages,
            seed=call.seed,
            kind=question.kind,
            observation=question.told,
            step=question.step,
            agent=question.agent,
            key=call.key,
        )

    def _keys_of(self, call: Call) -> RequestKeys:
        source = reply_of(call).source
        assert source is not None
        for known, keys in self._keys:
            if known.model == source.model and known.digest == source.digest and known.parameters == source.parameters:
                return keys
        self._keys.append((source, RequestKeys.of(source)))
        return self._keys[-1][1]

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        """Return the recorded replies."""
        return [reply.result() for reply in self.begin(requests)]

    def begin(self, requests: Sequence[Request]) -> list[asyncio.Future[Reply]]:
        """Return a future for each reply. All futures are done already, because the replies are recorded."""
        self.used += len(requests)
        return [there(reply_of(self._call(request))) for request in requests]

    def call(self, request: Request, reply: Reply) -> Call:
        """Return the recorded call, marked as answered by the cache."""
        return msgspec.structs.replace(self._call(request), cached=True)

    def _call(self, request: Request) -> Call:
        return self._asked_for[(request.step, request.agent, request.kind), request.key]


class ForkedAsker:
    """Gets answers before the step `at` from the records (`past`), and from this step on from the model (`future`)."""

    def __init__(self, past: Asks, future: Asks, at: int) -> None:
        self._past = past
        self._future = future
        self._at = at

    def request(self, question: Question) -> Request:
        """Return the request for a question."""
        return self._for(question.step).request(question)

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        """Return the replies; all requests must belong to one step."""
        return await self._for(requests[0].step).ask_all(requests) if requests else []

    def begin(self, requests: Sequence[Request]) -> list[asyncio.Future[Reply]]:
        """Send requests, which may belong to different steps, and return a future for each reply."""
        return [reply for request in requests for reply in self._for(request.step).begin([request])]

    def call(self, request: Request, reply: Reply) -> Call:
        """Return the entry for the log of calls: a request with its reply."""
        return self._for(request.step).call(request, reply)

    def _for(self, step: int) -> Asks:
        return self._past if step < self._at else self._future


def forked(asker: Asker, config: Mapping[str, Any], folder: SweepFolder) -> Asks:
    """Return the object that gets a run's answers: from `asker`, but before a fork begins, from the records."""
    if "fork" not in config:
        return asker
    fork = config["fork"]
    calls = read_calls(folder.origin_path(fork["run"], fork["at"]))
    return ForkedAsker(RecordedAsker(calls, past_wordings(config)), asker, fork["at"])


def origin_of(config: Mapping[str, Any]) -> Origin | None:
    """Return the run and the step that a fork continues; None for any other run."""
    if "fork" not in config:
        return None
    return msgspec.convert({key: value for key, value in config["fork"].items() if key != "past"}, Origin)
