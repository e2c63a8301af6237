"""Transport settings of models whose calls cost something; they never affect an answer."""

from collections.abc import Mapping
from contextvars import ContextVar
from typing import Annotated, Any, TypeVar

import msgspec

from foundry.errors import InputError
from foundry.models.base import Model

Seconds = Annotated[float, msgspec.Meta(gt=0)]
Count = Annotated[int, msgspec.Meta(ge=1)]
RUN: ContextVar[str | None] = ContextVar("RUN", default=None)
"""The run of the current task, if known; the calls of a run prefer one of several equal servers."""


class InFlight(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Bounds and first value of the limit on calls in flight, which `LimitedModel` adapts."""

    min: Count
    max: Count
    initial: Count

    def __post_init__(self) -> None:
        if not self.min <= self.initial <= self.max:
            raise ValueError(f"Expected min <= initial <= max, got {self.min}, {self.initial}, {self.max}")

    def from_slots(self, slots: int) -> "InFlight":
        """Return bounds that begin at their maximum: a call for each of the given slots, and one that waits."""
        most = max(self.min, min(self.max, slots + 1))
        return msgspec.structs.replace(self, max=most, initial=most)


class Retry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Number of tries of a call, and the waits of `RetriedModel` between them.

    Attributes:
        attempts: tries of a call, including the first.
        unusable_attempts: tries of a call that gets unusable replies.
        wait_initial_s: longest wait after the first failure, seconds; it doubles with every further failure.
        wait_max_s: longest wait, seconds, unless the server requests a longer one.
    """

    attempts: Count
    unusable_attempts: Count
    wait_initial_s: Seconds
    wait_max_s: Seconds


class Serving(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Transport settings of a model whose calls cost something.

    Attributes:
        in_flight: bounds of the calls in flight.
        retry: tries of a failed call.
        workers: number of worker processes that may ask the model at the same time; None for all of the runner.
    """

    in_flight: InFlight
    retry: Retry
    workers: Count | None = None


class Price(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Price of a million tokens of prompts and of a million tokens of replies, in any currency."""

    prompt: Annotated[float, msgspec.Meta(ge=0)]
    reply: Annotated[float, msgspec.Meta(ge=0)]


class HttpServing(Serving, frozen=True, kw_only=True):
    """Transport settings of a model behind one or more equal servers.

    Attributes:
        connect_timeout_s: limit for opening a connection, seconds.
        read_timeout_s: timeout for one reply, from the connection to its last byte, including the wait in the server's
            queue, seconds.
        longest_pause_s: longest wait that a server may request, seconds; a longer request ends the sweep.
        canary: whether canary calls are made.
        price: price of tokens, so that a plan can state the cost of a sweep; None if irrelevant.
    """

    connect_timeout_s: Seconds
    read_timeout_s: Seconds
    longest_pause_s: Seconds = 900.0
    canary: bool = True
    price: Price | None = None


DEFAULT = Serving(
    in_flight=InFlight(min=1, max=64, initial=2),
    retry=Retry(attempts=6, unusable_attempts=2, wait_initial_s=0.5, wait_max_s=30.0),
)
"""The transport settings of a model that has no settings of its own."""


def serving_of(model: Model) -> Serving:
    """Return the transport settings of a model whose calls cost something."""
    serving = getattr(model, "server", None)
    return serving if isinstance(serving, Serving) else DEFAULT


class ServedModel(Model):
    """A model whose calls cost something, so that answers are cached, and calls limited and repeated."""

    costs = True
    server: Serving


S = TypeVar("S", bound=Serving)


def read_settings(settings: Mapping[str, Any], kind: type[S]) -> S:
    """Return the checked settings under `server` of a model's YAML."""
    try:
        return msgspec.convert(dict(settings), kind)
    except msgspec.ValidationError as error:
        raise InputError(f"model.server: {error}. Correct it in conf/model/ or on the command line.") from None
