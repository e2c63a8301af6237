"""The loop, for every world: the pending questions are asked all at once, the world advances, records are kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from foundry.models.base import Model, Reply, Request, RequestKeys, Source, logged
from foundry.prompts.prompt import Prompt
from foundry.records import Call, Record
from foundry.worlds.base import Answer, Question, World


class Interrupted(Exception):
    """The episode was asked to stop before its end."""


class Recorder(Protocol):
    """Where an episode's records go."""

    def append(self, records: Sequence[Record]) -> None:
        """Keep what happened."""

    def append_calls(self, calls: Sequence[Call]) -> None:
        """Keep what was asked and answered."""

    def frame(self, step: int, png: bytes) -> None:
        """Keep a picture of the state after a step."""


class Asks(Protocol):
    """Turns questions into requests, and has them answered."""

    def request(self, question: Question) -> Request:
        """Return the request that puts this question."""

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        """Return the replies to requests, in their order."""

    def call(self, request: Request, reply: Reply) -> Call:
        """Return the log line of an answered request."""


@dataclass(frozen=True)
class Asker:
    """Turns questions into requests to one model.

    Attributes:
        model: the model, wrappers included.
        prompt: the prompt variant.
        digest: the model's digest on its server, or None.
        seed: the seed that the calls' sampling seeds are derived from.
    """

    model: Model
    prompt: Prompt
    digest: str | None
    seed: int
    keys: RequestKeys
    parameters: dict[str, Any]

    @classmethod
    def create(cls, model: Model, prompt: Prompt, *, digest: str | None, seed: int) -> Asker:
        """Return an asker; hashes the model's parameters once."""
        keys = RequestKeys(model, digest)
        return cls(model, prompt, digest, seed, keys, model.parameters())

    def request(self, question: Question) -> Request:
        """Return the request that puts this question."""
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
        """Return the model's replies to requests, in their order."""
        return await self.model.ask_all(requests)

    def call(self, request: Request, reply: Reply) -> Call:
        """Return the log line of an answered request."""
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
        )

    def _source(self, request: Request) -> Source:
        return Source(model=self.model.name, digest=self.digest, parameters=self.parameters, key=request.key)


async def play(
    world: World,
    asker: Asks,
    recorder: Recorder,
    *,
    frame_every: int = 0,
    stopping: Callable[[], bool] = lambda: False,
) -> None:
    """Play the world to its end.

    Args:
        world: a fresh episode.
        asker: the model and the prompt.
        recorder: where records go.
        frame_every: keep a picture of the initial state and of every n-th step after; 0 keeps none.
        stopping: asked before every round of questions.

    Raises:
        Interrupted: `stopping` said so.
        BackendError: the model gave no answer.
    """
    recorder.append(world.opening())
    if frame_every:
        recorder.frame(0, world.draw())
    while not world.finished:
        if stopping():
            raise Interrupted
        before = world.step
        requests = [asker.request(question) for question in world.pending()]
        replies = await asker.ask_all(requests)
        recorder.append_calls([asker.call(*pair) for pair in zip(requests, replies, strict=True)])
        recorder.append(world.advance([answer_of(reply) for reply in replies]))
        if frame_every and world.step != before and world.step % frame_every == 0:
            recorder.frame(world.step, world.draw())


def answer_of(reply: Reply) -> Answer:
    """Return a reply as the world sees it."""
    return Answer(reply.text, reply.ending, reply.timings.get("latency", 0.0))
