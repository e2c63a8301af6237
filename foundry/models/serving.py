"""Settings for making calls to a model: limits, repeats, timeouts. Such settings never affect an answer."""

from collections.abc import Mapping
from contextvars import ContextVar
from typing import Annotated, Any, TypeVar

import msgspec

from foundry.errors import InputError
from foundry.models.base import Model

Seconds = Annotated[float, msgspec.Meta(gt=0)]
Count = Annotated[int, msgspec.Meta(ge=1)]
RUN: ContextVar[str | None] = ContextVar("RUN", default=None)
"""Id of the run that the current task plays, if known. If several servers have the model of a run, most calls of the
run go to the same server.
"""


class InFlight(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Bounds and first value of the limit on calls in flight, which `LimitedModel` adapts."""

    min: Count
    max: Count
    initial: Count

    def __post_init__(self) -> None:
        if not self.min <= self.initial <= self.max:
            raise ValueError(
                f"in_flight needs min <= initial <= max, but has min={self.min}, initial={self.initial}, max={self.max}"
            )

    def from_slots(self, slots: int) -> "InFlight":
        """Return bounds for a server with known slots: at most one call per slot and one that waits."""
        most = max(self.min, min(self.max, slots + 1))
        return msgspec.structs.replace(self, max=most, initial=most)


class Retry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How often `RetriedModel` tries a call, and how long it waits between tries.

    Attributes:
        attempts: tries of a call, including the first.
        unusable_attempts: tries of a call whose replies are unusable.
        wait_initial_s: longest wait after the first failure, seconds. This wait doubles with every further failure.
        wait_max_s: longest wait after any failure, seconds, unless the server requests a longer one.
    """

    attempts: Count
    unusable_attempts: Count
    wait_initial_s: Seconds
    wait_max_s: Seconds


class Serving(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Settings for calls to a model if they cost time or money.

    Attributes:
        in_flight: bounds of the number of calls in flight.
        retry: how failed calls are repeated.
        workers: number of worker processes that may ask the model at the same time; None allows all of the runner.
    """

    in_flight: InFlight
    retry: Retry
    workers: Count | None = None


class Price(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Price of a million tokens of prompts and of a million tokens of replies, in any currency."""

    prompt: Annotated[float, msgspec.Meta(ge=0)]
    reply: Annotated[float, msgspec.Meta(ge=0)]


class HttpServing(Serving, frozen=True, kw_only=True):
    """Settings for calls to a model behind one or more equal HTTP servers.

    Attributes:
        connect_timeout_s: longest time for opening a connection, seconds.
        read_timeout_s: longest time for a whole reply, with the wait in the server's queue, seconds.
        longest_pause_s: longest pause that a server may request, seconds. A longer pause ends the sweep.
        canary: whether canary calls are made.
        price: price of tokens, from which a plan computes the cost of a sweep; None if no cost is wanted.
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
"""The serving settings of a model whose class has no attribute `server`."""


def serving_of(model: Model) -> Serving:
    """Return a model's settings for its calls; if the model has no such settings, the default settings."""
    serving = getattr(model, "server", None)
    return serving if isinstance(serving, Serving) else DEFAULT


class ServedModel(Model):
    """A model whose calls cost time or money, so that answers are cached, and calls limited and repeated."""

    costs = True
    server: Serving


S = TypeVar("S", bound=Serving)


def read_settings(settings: Mapping[str, Any], kind: type[S]) -> S:
    """Check the settings under `server` of a model's YAML file, and return them as an object."""
    try:
        return msgspec.convert(dict(settings), kind)
    except msgspec.ValidationError as error:
        raise InputError(f"model.server: {error}. Correct it in conf/model/ or on the command line.") from None
