"""The interface of a model: it takes requests and returns replies; wrappers have this interface too."""

from __future__ import annotations

import asyncio
import hashlib
import inspect
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias, TypeVar

import msgspec
from numpy.random import Generator

from foundry import seeding
from foundry.canary import Canary, TokenLogprobs
from foundry.errors import TransientError, not_found
from foundry.records import Attempt, Member
from foundry.worlds.base import Question

T = TypeVar("T")


async def seen_through(calls: Iterable[Awaitable[T]]) -> list[T]:
    """Run calls at the same time and return their results in order; raise the first error once all have ended."""
    results = await asyncio.gather(*calls, return_exceptions=True)
    values: list[T] = []
    for result in results:
        if isinstance(result, BaseException):
            raise result
        values.append(result)
    return values


class ChatMessage(msgspec.Struct, frozen=True):
    """One message of a prompt; `images` are PNG or JPEG bytes."""

    role: str
    content: str
    images: tuple[bytes, ...] = ()


class Request(msgspec.Struct, frozen=True):
    """One model call as the backend sees it.

    Attributes:
        messages: the rendered prompt.
        seed: sampling seed, 0..2^31-1.
        observation: input of scripted models, with the data that only they get; no server ever gets this input.
        step: 1-based step.
        key: hash of everything that affects the answer; the key of the answer cache.
        options: a reply for each legal decision, if the world declares them.
        idle: the reply that decides to do nothing, or None.
    """

    messages: tuple[ChatMessage, ...]
    seed: int
    kind: str
    observation: Mapping[str, Any]
    step: int
    agent: int
    key: str = ""
    options: tuple[str, ...] = ()
    idle: str | None = None


class Source(msgspec.Struct, frozen=True, kw_only=True):
    """The model that gave a reply, if it is not the asked model: the asked model may be a population or a replay.

    Attributes:
        digest: digest of the model on its server, or None.
        parameters: everything besides messages and seed that affects the answer.
        key: hash of everything that affects the answer.
    """

    model: str
    digest: str | None
    parameters: dict[str, Any]
    key: str


class Reply(msgspec.Struct, frozen=True, kw_only=True):
    """The reply to a request. The answer cache stores every field of a reply.

    Attributes:
        thinking: the separate thinking text, or None.
        ending: `stop`, `length` or `aborted` (the backend gave up on this call).
        prompt_tokens: tokens of the prompt, or None where unknown.
        output_tokens: tokens of the reply, or None where unknown.
        timings: seconds by name: `total`, `load`, `prompt`, `output`, `queue` (all by the server's clock),
            `latency` (by the client's).
        attempts: failed tries of the call before this answer.
        host: base URL of the answering server, or None.
        server_version: version of the server, else the fingerprint that it reports, else None.
        served_model: name of the model in the server's reply, or None.
        cached_tokens: prompt tokens that the server took from its prompt cache; None if not reported.
        remote: model and address to which the server passed the call, or None.
        cached: whether the reply came from foundry's cache of answers.
        source: the model that gave the reply, if it is not the asked model.
        logprobs: tokens of the reply with their log-probabilities; empty if not requested or not reported.
    """

    text: str
    thinking: str | None = None
    ending: str = "stop"
    prompt_tokens: int | None = None
    output_tokens: int | None = None
    timings: dict[str, float] = msgspec.field(default_factory=dict)
    attempts: tuple[Attempt, ...] = ()
    host: str | None = None
    server_version: str | None = None
    served_model: str | None = None
    cached_tokens: int | None = None
    remote: str | None = None
    cached: bool = False
    source: Source | None = None
    logprobs: tuple[TokenLogprobs, ...] = ()


class UnusableReply(TransientError):
    """A reply without usable content. The call is repeated; if no try gives a usable reply, this reply is the answer.

    Attributes:
        reply: the reply as received: a reply without text, with the ending `stop` or `aborted`.
    """

    def __init__(self, message: str, reply: Reply) -> None:
        super().__init__(message)
        self.reply = reply


@dataclass(frozen=True, slots=True)
class ModelInfo:
    """Facts about a model, as its server reports them.

    Attributes:
        digest: hash of the weights, template and parameters; it is part of the keys of answers. None for policies.
        weights: the same hash without the server's flags; None if `digest` contains no flags.
        capabilities: such as `completion`, `vision`, `thinking`.
        undeclared: capabilities about which the server reports nothing; the user declares them by settings of these
            names.
        context_length: longest context in tokens, or None where unknown.
        slots: number of calls that the servers process at the same time, or None where unknown.
        remote: model and address to which the server passes calls, or None.
        measured: True if the server reports no digest, so that `digest` identifies the weights by the canary.
        members: models to which a population passes requests.
        states: further facts that change when the weights are replaced, by base URL of each server. The digest alone
            does not show that weights were replaced and restored.
    """

    name: str
    digest: str | None = None
    weights: str | None = None
    server_version: str | None = None
    capabilities: tuple[str, ...] = ()
    undeclared: tuple[str, ...] = ()
    context_length: int | None = None
    slots: int | None = None
    remote: str | None = None
    measured: bool = False
    members: tuple[ModelInfo, ...] = ()
    states: Mapping[str, str] = field(default_factory=dict)

    @property
    def identity(self) -> str | None:
        """Hash of the model that must not change during a sweep; None if the server reports no hash."""
        return self.weights or self.digest


@dataclass(frozen=True, slots=True)
class Loaded:
    """A server's report on a loaded model; a fact is None if the server does not report it.

    Attributes:
        slots: number of calls that the server processes at the same time.
        context_length: maximum number of tokens of one call.
        on_cpu: share of the model outside the GPU's memory, 0 to 1.
    """

    slots: int | None = None
    context_length: int | None = None
    on_cpu: float | None = None

    @classmethod
    def of_all(cls, servers: Iterable[Loaded]) -> Loaded:
        """Return one report on several servers: the sum of slots, the shortest context and the largest CPU share."""
        servers = list(servers)
        slots = [server.slots for server in servers]
        lengths = [server.context_length for server in servers if server.context_length is not None]
        shares = [server.on_cpu for server in servers if server.on_cpu is not None]
        total = None if None in slots else sum(filter(None, slots))
        return cls(total, min(lengths, default=None), max(shares, default=None))


@dataclass(frozen=True, slots=True)
class RunContext:
    """The facts about a run that a model gets before it answers.

    Attributes:
        calls_seed: seed from which the sampling seed of each call is derived.
        personas: persona of every agent, in the order of the agents' ids.
    """

    seed: int
    calls_seed: int
    personas: Sequence[Mapping[str, str]]
    info: ModelInfo


class Model(ABC):
    """Answers requests.

    Attributes:
        name: name of the model in tables and records.
        costs: whether calls cost time or money. If calls cost something, foundry caches answers, and limits and repeats
            calls. The settings for this are the attribute `server` (`serving.Serving`), or `serving.DEFAULT` if the
            model has no such attribute.
        in_process: whether the model runs in the asking process, so that each worker has a copy.
        replaceable: whether the weights may be replaced during a sweep. If they may be, foundry calls `inspect` again
            and again, and compares the digest.
    """

    costs: bool = False
    in_process: bool = False
    replaceable: bool = True
    name: str

    @abstractmethod
    async def ask(self, request: Request) -> Reply:
        """Answer one request.

        Raises:
            TransientError: another try may succeed.
            RequestError: this request can never succeed.
            ServerError: no request can succeed.
        """

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        """Answer several requests at the same time, in order.

        All calls end before the first error is raised, so that no answer is lost.
        """
        return await seen_through(map(self.ask, requests))

    def begin(self, requests: Sequence[Request]) -> list[asyncio.Future[Reply]]:
        """Begin to answer several requests, and return a future for each reply."""
        return [asyncio.ensure_future(self.ask(request)) for request in requests]

    @abstractmethod
    def parameters(self) -> dict[str, Any]:
        """Return the fields of a call that affect the answer, without messages and seed."""

    @property
    def kinds(self) -> tuple[str, ...] | None:
        """The kinds of question that the model can answer; None if it can answer any."""
        return None

    def check(self, question: Question) -> None:
        """Raise an error if the model cannot answer a question; preflight checks the first question of each kind.

        Raises:
            InputError: the model cannot answer the questions.
        """

    def in_run(self, context: RunContext) -> Model:
        """Return the model that answers in one run: this model or, for a population, its members with their agents.

        Raises:
            InputError: the model does not fit the run.
        """
        return self

    def wrapped(self, wrap: Callable[[Model], Model]) -> Model:
        """Return the model with a wrapper around it; in a population, each member gets a wrapper."""
        return wrap(self)

    def costs_for(self, agent: int) -> bool:
        """Return whether calls for this agent cost something."""
        return self.costs

    def roster(self) -> tuple[Member, ...]:
        """Return which member answers for which agents; empty if the model is no population."""
        return ()

    @property
    def longest_reply(self) -> int | None:
        """Maximum number of tokens of a reply that the settings allow; None without a limit."""
        return None

    @property
    def context_length(self) -> int | None:
        """Maximum number of tokens of prompt and reply that the settings allow; None if the server decides."""
        return None

    async def inspect(self) -> ModelInfo:
        """Ask the server about the model.

        Raises:
            InputError: the server cannot be reached or lacks the model.
        """
        return ModelInfo(name=self.name)

    async def loaded(self) -> Loaded:
        """Ask the server about its loaded model.

        Raises:
            BackendError: the server does not answer.
        """
        return Loaded()

    def next_served(self) -> Callable[[str | None], bool]:
        """Return a function that says whether a run's next call should go to the server that has the most room now."""
        return every_run

    @property
    def connections(self) -> int:
        """Number of connections opened to the server so far; a restarted server needs a new connection."""
        return 0

    def weights_of(self, reply: Reply) -> Mapping[str, str]:
        """Return, by name, the facts in a reply that show which weights answered."""
        return {}

    def canary_models(self, likeliest: int | None) -> Mapping[str, Model]:
        """Return, by base URL of each server, a copy of the model that makes greedy, short calls for the canary.

        Args:
            likeliest: number of log-probabilities per token; None requests none.
        """
        return {}

    def canaries(self) -> tuple[Canary, ...]:
        """Return the results of the canary calls, for the model or for each member of a population."""
        return ()

    async def confirm(self) -> None:
        """Check that the server still has the model with which the sweep started.

        Raises:
            ModelChangedError: the server has a different model under this name.
            TransientError: the server does not answer.
        """

    async def warm_up(self) -> None:
        """Load the model, with a long timeout, before many calls start."""

    async def unload(self) -> None:
        """Let the server free the model's memory."""

    async def close(self) -> None:
        """Free connections."""


def every_run(run: str | None) -> bool:
    """Return True, since one server can take the call of any run."""
    return True


def there(reply: Reply) -> asyncio.Future[Reply]:
    """Return a future that is already done, with this reply as its result."""
    future: asyncio.Future[Reply] = asyncio.get_running_loop().create_future()
    future.set_result(reply)
    return future


class RequestKeys:
    """Makes the keys of answers: hashes of model, digest, parameters, sampling seed and messages."""

    def __init__(self, model: Model, digest: str | None) -> None:
        self._prefix = _prefix(model.name, digest, model.parameters())

    @classmethod
    def of(cls, source: Source) -> RequestKeys:
        """Return an object that makes the cache keys of the model in a record, which need not be configured now."""
        keys = cls.__new__(cls)
        keys._prefix = _prefix(source.model, source.digest, source.parameters)
        return keys

    def key(self, messages: Sequence[ChatMessage], seed: int) -> str:
        """Return the key of a request."""
        state = self._prefix.copy()
        state.update(seed.to_bytes(8, "little"))
        for message in messages:
            state.update(_framed(message.role.encode()) + _framed(message.content.encode()))
            for image in message.images:
                state.update(_framed(image))
        return state.hexdigest()


def logged(message: ChatMessage) -> dict[str, Any]:
    """Return a message as the log of calls records it: each image is replaced by its SHA-256."""
    line: dict[str, Any] = {"role": message.role, "content": message.content}
    if message.images:
        line["images_sha256"] = [hashlib.sha256(image).hexdigest() for image in message.images]
    return line


def _prefix(name: str, digest: str | None, parameters: Mapping[str, Any]) -> hashlib.blake2b:
    state = hashlib.blake2b(digest_size=20)
    for part in (name.encode(), (digest or "").encode(), msgspec.json.encode(parameters, order="deterministic")):
        state.update(_framed(part))
    return state


def _framed(part: bytes) -> bytes:
    return len(part).to_bytes(8, "little") + part


Observation: TypeAlias = Mapping[str, Any]
Policy: TypeAlias = Callable[[Observation, Generator], str]


class ScriptedModel(Model):
    """A policy in Python. A subclass has one method per kind of question, such as `action`, with the name of the kind.

    The method gets the observation, which it must not change, and a random generator for this call. The method returns
    the text of the reply.
    """

    def __init__(self, name: str, **settings: Any) -> None:
        """Set the name of the model, and the settings on which its replies depend."""
        self.name, self.settings = name, settings
        self._policies = _policies(self)
        # Each class has a separate stream, so that a policy that wraps another does not use up the other's draws.
        self._stream = f"policy:{type(self).__name__}"

    @property
    def kinds(self) -> tuple[str, ...] | None:
        """The kinds of question that the policy can answer."""
        return tuple(self._policies)

    def reply(self, request: Request) -> Reply:
        """Answer one request."""
        policy = self._policies.get(request.kind)
        if policy is None:
            raise not_found(f"Policy of model '{self.name}' for questions of kind", request.kind, self._policies)
        return Reply(text=policy(request.observation, self.generator(request)))

    def generator(self, request: Request) -> Generator:
        """Return the random generator that this policy uses for this call."""
        return seeding.stream(request.seed, self._stream)

    async def ask(self, request: Request) -> Reply:
        """Answer one request."""
        return self.reply(request)

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        """Answer several requests one after another, without an asyncio task for each request."""
        return [self.reply(request) for request in requests]

    def parameters(self) -> dict[str, Any]:
        """Return the policy's class and its settings."""
        return {"policy": type(self).__name__, **self.settings}


def _policies(model: ScriptedModel) -> dict[str, Policy]:
    return {
        name: getattr(model, name)
        for name, _ in inspect.getmembers(type(model), inspect.isfunction)
        if not name.startswith("_") and not hasattr(ScriptedModel, name)
    }
