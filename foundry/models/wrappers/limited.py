"""A model with a limit on the calls in flight that adapts to what its server can do."""

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
"""Calls that may follow one that ended: where the limit rose, they come one by one and not in a burst."""

LOOK_AHEAD = 256
"""Waiting calls among which one is looked for that suits the server that is free."""


class Limit:
    """Lets so many calls to a server be in flight, first come first served, and sums up what comes of them.

    Where there are several servers, those come first that suit the one that is free.

    It finds the number itself, unless it is one of several workers' and told its share (`allow`).

    Attributes:
        bounds: the least and the most that may be in flight, and where to start.
        allowed: how many may be in flight now.
        in_flight: how many are.
    """

    def __init__(self, bounds: InFlight, *, clock: Callable[[], float] = time.perf_counter) -> None:
        """Set the bounds; `clock` is the time in seconds."""
        self.bounds = bounds
        self.allowed = bounds.initial
        self.in_flight = 0
        self._climb: Climb | None = climb_within(bounds, bounds.initial, found=False)
        self._sums = Sums()
        self._waiters: dict[asyncio.Future[None], str | None] = {}
        self._clock = clock
        self._now = self._changed = clock()

    @property
    def waiting(self) -> int:
        """How many calls wait for their turn."""
        return len(self._waiters)

    @property
    def sums(self) -> Sums:
        """What came of the calls so far."""
        self._pass_time()
        return self._sums

    async def acquire(self) -> float:
        """Wait for a turn; returns when it came, in seconds."""
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
        """Give a turn back, to whoever waits; to the calls of a run that suits before others."""
        self._pass_time()
        self.in_flight -= 1
        for _ in range(PACE):
            turn = self._next(suits) if self.in_flight < self.allowed else None
            if turn is not None:
                self.in_flight += 1
                del self._waiters[turn]
                turn.set_result(None)

    def note_reply(self, reply: Reply, started: float) -> None:
        """Take up the answer to a call whose turn came at this time."""
        self._pass_time()
        self._sums.note(float(reply.output_tokens or 1), self._now - started, reply.timings.get("queue"))
        self._look()

    def note_failure(self, error: TransientError, started: float) -> None:
        """Take up a try that failed; one that was begun under an earlier limit says nothing of this one."""
        if (error.busy or error.late) and started >= self._changed:
            self._pass_time()
            self._sums.refused += 1
            self._look()

    def share(self) -> None:
        """Take the number from others from now on."""
        self._climb = None

    def find(self, initial: int, *, found: bool) -> None:
        """Find the number alone from now on, beginning at this one, which may have been found before."""
        self._climb = climb_within(self.bounds, initial, found=found)
        self.allow(self._climb.limit)

    @property
    def is_shared(self) -> bool:
        """Whether the number is told."""
        return self._climb is None

    def allow(self, allowed: int) -> None:
        """Let so many calls be in flight from now on."""
        if allowed != self.allowed:
            self._pass_time()
            self.allowed, self._changed = allowed, self._now

    def _look(self) -> None:
        if self._climb is not None and self.bounds.min < self.bounds.max:
            self._climb.look(self._sums)
            self.allow(self._climb.limit)

    def _next(self, suits: Callable[[str | None], bool]) -> asyncio.Future[None] | None:
        """Return whose turn it is, if anyone waits."""
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


def climb_within(bounds: InFlight, initial: int, *, found: bool) -> Climb:
    """Return a climb between the bounds from this limit, which may have been found before."""
    start = max(bounds.min, min(bounds.max, initial))
    return Climb(least=bounds.min, most=bounds.max, initial=start, found=found)


class LimitedModel(Wrapper):
    """Asks the wrapped model as often at once as a limit allows; the tries of one call keep its turn."""

    def __init__(self, inner: Model, limit: Limit) -> None:
        super().__init__(inner)
        self.limit = limit

    async def ask(self, request: Request) -> Reply:
        """Answer one request when its turn comes."""
        started = await self.limit.acquire()
        try:
            reply = await self.inner.ask(request)
            self.limit.note_reply(reply, started)
            return reply
        finally:
            self.limit.release(self.inner.next_served())
