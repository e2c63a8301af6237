"""The loop that plays every world: ask all pending questions at once, let the world advance, store the records.

Some worlds know an agent's next question before other agents have answered theirs. If replies take time, foundry asks
each agent as early as possible, without waiting for the slowest reply of the round. Early questions do not change the
records: foundry still records one whole round after another.
"""

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import msgspec

from foundry.errors import FoundryError, Interrupted
from foundry.models.base import Model, Reply, Request, RequestKeys, Source, logged
from foundry.prompts.prompt import Prompt
from foundry.records import Call, Record
from foundry.worlds.base import Ahead, Answer, Question, QuestionKey, World


class Recorder(Protocol):
    """Stores the records, calls and pictures of an episode."""

    def append(self, records: Sequence[Record]) -> None:
        """Store records of the world."""

    def append_calls(self, calls: Sequence[Call]) -> None:
        """Append calls to the log of calls."""

    def frame(self, step: int, png: bytes) -> None:
        """Store a picture of the state after a step."""


class Asks(Protocol):
    """Converts questions to requests, and gets the replies."""

    def request(self, question: Question) -> Request:
        """Return the request for this question."""

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        """Return the reply to each request, in order."""

    def begin(self, requests: Sequence[Request]) -> list[asyncio.Future[Reply]]:
        """Send requests, and return a future for each reply."""

    def call(self, request: Request, reply: Reply) -> Call:
        """Return the entry for the log of calls: a request with its reply."""


@dataclass(frozen=True)
class Asker:
    """Sends the questions of a run to one model, with one prompt.

    Attributes:
        digest: hash of the model's weights on its server, or None.
        seed: seed from which the calls' sampling seeds are derived.
        parameters: the model's parameters, for the log of calls.
    """

    model: Model
    prompt: Prompt
    digest: str | None
    seed: int
    keys: RequestKeys
    parameters: dict[str, Any]

    @classmethod
    def create(cls, model: Model, prompt: Prompt, *, digest: str | None, seed: int) -> "Asker":
        """Return an asker, which hashes the model's parameters only now and not for each request."""
        keys = RequestKeys(model, digest)
        return cls(model, prompt, digest, seed, keys, model.parameters())

    def request(self, question: Question) -> Request:
        """Return the request for this question."""
        messages = self.prompt.render(question)
        seed = question.sampling_seed(self.seed)
        return Request(
            messages=messages,
            seed=seed,
            kind=question.kind,
            observation=question.told,
            step=question.step,
            agent=question.agent,
            key=self.keys.key(messages, seed),
            options=question.options,
            idle=question.idle,
        )

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        """Return the model's reply to each request, in order."""
        return await self.model.ask_all(requests)

    def begin(self, requests: Sequence[Request]) -> list[asyncio.Future[Reply]]:
        """Send requests to the model, and return a future for each reply."""
        return self.model.begin(requests)

    def call(self, request: Request, reply: Reply) -> Call:
        """Return the entry for the log of calls: a request with its reply."""
        source = reply.source or self._source(request)
        return Call(
            step=request.step,
            agent=request.agent,
            kind=request.kind,
            model=source.model,
            digest=source.digest,
            key=source.key,
            seed=request.seed,
            messages=[logged(message) for message in request.messages],
            parameters=source.parameters,
            text=reply.text,
            thinking=reply.thinking,
            ending=reply.ending,
            prompt_tokens=reply.prompt_tokens,
            output_tokens=reply.output_tokens,
            timings=reply.timings,
            attempts=reply.attempts,
            host=reply.host,
            cached=reply.cached,
            server_version=reply.server_version,
            served_model=reply.served_model,
            cached_tokens=reply.cached_tokens,
            remote=reply.remote,
            logprobs=reply.logprobs or msgspec.UNSET,
        )

    def _source(self, request: Request) -> Source:
        return Source(model=self.model.name, digest=self.digest, parameters=self.parameters, key=request.key)


async def play(
    world: World,
    asker: Asks,
    recorder: Recorder,
    *,
    frame_every: int = 0,
    ahead: bool = True,
    stopping: Callable[[], bool] = lambda: False,
) -> None:
    """Play the world to its end.

    Args:
        world: a fresh episode.
        asker: the model and the prompt.
        recorder: stores the records.
        frame_every: number of steps between recorded pictures, which begin with the initial state; 0 for none.
        ahead: whether to ask questions before their round, if the world allows it and answers take time.
        stopping: function that is called before each round; if it returns True, the episode is interrupted.
    """
    episode = _Episode(world, asker, recorder, frame_every)
    recorder.append(world.opening())
    if frame_every:
        recorder.frame(0, world.draw())
    while not world.finished:
        if stopping():
            raise Interrupted
        waited = await episode.ask_round()
        further = world.ahead() if ahead and waited and not world.finished else None
        if further is not None:
            await _AskedAhead(episode, further, stopping).play()


@dataclass(frozen=True)
class _Episode:
    world: World
    asker: Asks
    recorder: Recorder
    frame_every: int

    async def ask_round(self) -> bool:
        """Play one round; return whether an answer came from a server, which takes time, and not from the cache."""
        requests = [self.asker.request(question) for question in self.world.pending()]
        replies = await self.asker.ask_all(requests)
        calls = [self.asker.call(*pair) for pair in zip(requests, replies, strict=True)]
        answers = [answer_of(reply) for reply in replies]
        self.keep(calls, answers)
        return any(answer.inference_s and not reply.cached for answer, reply in zip(answers, replies, strict=True))

    def keep(self, calls: Sequence[Call], answers: Sequence[Answer]) -> None:
        """Give the world the answers of one round; store its calls, its records and, if due, a picture."""
        before = self.world.step
        self.recorder.append_calls(calls)
        self.recorder.append(self.world.advance(answers))
        step = self.world.step
        if self.frame_every and step != before and step % self.frame_every == 0:
            self.recorder.frame(step, self.world.draw())


class _AskedAhead:
    """Plays an episode to its end: asks each question as soon as the world knows it, and records rounds in order."""

    def __init__(self, episode: _Episode, ahead: Ahead, stopping: Callable[[], bool]) -> None:
        self._episode = episode
        self._ahead = ahead
        self._stopping = stopping
        self._awaited: dict[asyncio.Future[Reply], Request] = {}
        self._there: asyncio.Queue[asyncio.Future[Reply]] = asyncio.Queue()
        self._answered: dict[QuestionKey, tuple[Call, Answer]] = {}
        self._failed: dict[QuestionKey, Exception] = {}

    async def play(self) -> None:
        """Play the world to its end. Raise an error only after all open calls: no answer is lost."""
        try:
            while not self._episode.world.finished:
                is_stopping = self._stopping()
                if not is_stopping:
                    self._ask()
                if not self._awaited:
                    self._fail(is_stopping)
                await self._take()
        except asyncio.CancelledError:
            for reply in self._awaited:
                reply.cancel()
            raise
        finally:
            await asyncio.gather(*self._awaited, return_exceptions=True)

    def _ask(self) -> None:
        """Ask all questions that are known now. After a failed call, ask no question about a later step."""
        last = min((step for step, _, _ in self._failed), default=None)
        questions = [question for question in self._ahead.ready() if last is None or question.step <= last]
        requests = [request for question in questions if (request := self._request(question)) is not None]
        replies = self._episode.asker.begin(requests) if requests else []
        for reply, request in zip(replies, requests, strict=True):
            self._awaited[reply] = request
            reply.add_done_callback(self._there.put_nowait)

    def _request(self, question: Question) -> Request | None:
        try:
            return self._episode.asker.request(question)
        except Exception as error:  # noqa: BLE001 - raised when the world reaches this question
            self._failed[question.asked] = error
            return None

    async def _take(self) -> None:
        there = [await self._there.get()]
        while not self._there.empty():
            there.append(self._there.get_nowait())
        for reply in there:
            request = self._awaited.pop(reply)
            place = request.step, request.agent, request.kind
            error = reply.exception()
            if isinstance(error, Exception):
                self._failed[place] = error
                continue
            answer = answer_of(reply.result())
            self._answered[place] = self._episode.asker.call(request, reply.result()), answer
            self._ahead.take(place, answer)
        while whole := self._ahead.next_round():
            answers = [self._answered.pop(place) for place in whole]
            self._episode.keep([call for call, _ in answers], [answer for _, answer in answers])

    def _fail(self, is_stopping: bool) -> None:
        pending = (question.asked for question in self._episode.world.pending())
        first = next((self._failed[asked] for asked in pending if asked in self._failed), None)
        if first is not None:
            raise first
        if is_stopping:
            raise Interrupted
        raise FoundryError("The world is not finished, but its `ahead` asks nothing: correct its method `ready`.")


def answer_of(reply: Reply) -> Answer:
    """Convert a reply of a model to an answer for a world."""
    logprobs = () if reply.thinking else reply.logprobs
    return Answer(reply.text, reply.ending, reply.timings.get("latency", 0.0), logprobs)
