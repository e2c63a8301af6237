"""Limits the calls in flight to a model; the limit adapts to the capacity of the server."""

import asyncio
import time
from collections.abc import Callable
from itertools import islice

from foundry.errors import TransientError
from foundry.models.base import Model, Reply, Request, every_run
from foundry.models.serving import RUN, InFlight
from foundry.models.wrappers.climbing import Climb, Sums
from foundry.models.wrappers.wrapper import Wrapper

PACE = 2
"""Number of calls that may start when a call ends, so that calls start gradually after the limit has risen."""

LOOK_AHEAD = 256
"""The call for a free server is chosen among this number of calls that wait longest."""


class Limit:
    """Limits the calls in flight to a server, first come first served, and sums up their results.

    With several servers, calls that suit the free server come first. The limit is found by a climb, unless several
    workers share one limit; then `allow` sets the share of this worker.

    Attributes:
        bounds: minimum, maximum and first value of the limit.
        allowed: number of calls that may be in flight now.
        in_flight: number of calls in flight now.
    """

    def __init__(self, bounds: InFlight, *, clock: Callable[[], float] = time.perf_counter) -> None:
        """Set the bounds of the limit, and the clock: a function that returns the time in seconds."""
        self.bounds = bounds
        self.allowed = bounds.initial
        self.in_flight = 0
        self._climb: Climb | None = climb_within(bounds, bounds.initial, known=False)
        self._sums = Sums()
        self._waiters: dict[asyncio.Future[None], str | None] = {}
        self._clock = clock
        self._now = self._changed = clock()

    @property
    def waiting(self) -> int:
        """Number of waiting calls."""
        return len(self._waiters)

    @property
    def sums(self) -> Sums:
        """Sums over all calls so far, such as their number, tokens and time."""
        self._pass_time()
        return self._sums

    async def acquire(self) -> float:
        """Wait until the call may start, and return the time of its start, seconds."""
        self._pass_time()
        if self.in_flight < self.allowed and not self._waiters:
            self.in_flight += 1
            return self._now
        turn = asyncio.get_running_loop().create_future()
        self._waiters[turn] = RUN.get()
        try:
            await turn
        except asyncio.CancelledError:
            self._waiters.pop(turn, None)
            if not turn.cancelled():  # the turn was given before the cancellation arrived
                self.release()
            raise
        self._pass_time()
        return self._now

    def release(self, suits: Callable[[str | None], bool] = every_run) -> None:
        """Count a call as ended, and let waiting calls start, first those for which `suits` is true."""
        self._pass_time()
        self.in_flight -= 1
        for _ in range(PACE):
            turn = self._next(suits) if self.in_flight < self.allowed else None
            if turn is not None:
                self.in_flight += 1
                del self._waiters[turn]
                turn.set_result(None)

    def note_reply(self, reply: Reply, started: float) -> None:
        """Record a reply; its call started at the time `started`, seconds."""
        self._pass_time()
        self._sums.note(float(reply.output_tokens or 1), self._now - started, reply.timings.get("queue"))
        self._look()

    def note_failure(self, error: TransientError, started: float) -> None:
        """Count a failed try against the limit, unless the try started before the last change of the limit."""
        if (error.busy or error.late) and started >= self._changed:
            self._pass_time()
            self._sums.refused += 1
            self._look()

    def share(self) -> None:
        """Stop adapting the limit: from now on, only the method `allow` sets the limit."""
        self._climb = None

    def find(self, initial: int, *, known: bool) -> None:
        """Search for the best limit again, from `initial`; `known` says whether an earlier search found this value."""
        self._climb = climb_within(self.bounds, initial, known=known)
        self.allow(self._climb.limit)

    @property
    def is_shared(self) -> bool:
        """True if only the method `allow` sets the limit; False if the limit is adapted by trial."""
        return self._climb is None

    def allow(self, allowed: int) -> None:
        """Set the number of calls that may be in flight."""
        if allowed != self.allowed:
            self._pass_time()
            self.allowed, self._changed = allowed, self._now

    def _look(self) -> None:
        if self._climb is not None and self.bounds.min < self.bounds.max:
            self._climb.look(self._sums)
            self.allow(self._climb.limit)

    def _next(self, suits: Callable[[str | None], bool]) -> asyncio.Future[None] | None:
        first = None
        for turn, run in islice(self._waiters.items(), LOOK_AHEAD):
            if not turn.cancelled():
                if suits(run):
                    return turn
                first = first or turn
        return first

    def _pass_time(self) -> None:
        now = self._clock()
        passed = now - self._now
        self._now = now
        self._sums.clock_s += passed
        self._sums.in_flight_s += passed * self.in_flight
        if self._waiters:
            self._sums.waiting_s += passed


def climb_within(bounds: InFlight, initial: int, *, known: bool) -> Climb:
    """Return a search for the best limit, from `initial` within the bounds; `known`: an earlier search found `initial`.

    If the first value of the bounds is their maximum, as for known slots, no smaller limit is tried.
    """
    start, only_up = max(bounds.min, min(bounds.max, initial)), bounds.initial == bounds.max
    return Climb(least=bounds.min, most=bounds.max, initial=start, known=known, only_up=only_up)


class LimitedModel(Wrapper):
    """Limits the calls in flight to the wrapped model; a call still counts as in flight while it is repeated."""

    def __init__(self, inner: Model, limit: Limit) -> None:
        super().__init__(inner)
        self.limit = limit

    async def ask(self, request: Request) -> Reply:
        """Answer one request as soon as the limit allows it."""
        started = await self.limit.acquire()
        try:
            reply = await self.inner.ask(request)
            self.limit.note_reply(reply, started)
            return reply
        finally:
            self.limit.release(self.inner.next_served())
