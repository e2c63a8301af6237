"""A model with a limit on the calls in flight that adapts to what its server can do."""

from __future__ import annotations

import asyncio
import time
from collections import deque

from foundry.errors import TransientError
from foundry.models.base import Model, Reply, Request
from foundry.models.wrappers.base import Wrapper

ALPHA = 1.0
"""Fewer own calls than this in the server's queue: it may be idle at times, so the limit grows."""
BETA = 3.0
"""More own calls than this in the server's queue: they only wait there, so the limit shrinks."""


class LimitedModel(Wrapper):
    """Keeps the server busy with one to three calls waiting in its queue, as TCP Vegas does with packets.

    How many calls a server works on at once depends on its settings, the model and the memory, and is not
    reported; so the limit is found: per window of `limit` calls, the share of their time spent waiting,
    times the limit, is the number of own calls in the server's queue. Below `ALPHA` the limit grows, by
    doubling until the first sign of a queue; above `BETA` it shrinks by one; a refusal (503, 429) halves it.
    Only calls that started within the window count, so one cause never moves the limit twice.
    """

    def __init__(self, inner: Model, *, min: int, max: int, initial: int) -> None:
        super().__init__(inner)
        self._min = min
        self._max = max
        self._limit = initial
        self._in_flight = 0
        self._waiters: deque[asyncio.Future[None]] = deque()
        self._doubling = True
        self._least_latency = float("inf")
        self._window = 0
        self._replies = 0
        self._wait_s = 0.0
        self._latency_s = 0.0
        self._reached = False

    @property
    def limit(self) -> int:
        """How many calls may be in flight now."""
        return self._limit

    @property
    def in_flight(self) -> int:
        """How many calls are in flight."""
        return self._in_flight

    @property
    def waiting(self) -> int:
        """How many calls wait for a slot, first come first served."""
        return len(self._waiters)

    async def ask(self, request: Request) -> Reply:
        """Answer one request when a slot is free."""
        await self._acquire()
        window, started = self._window, time.perf_counter()
        try:
            reply = await self.inner.ask(request)
        except TransientError as error:
            self._note_refusal(window, refused=error.busy)
            raise
        else:
            self._note_refusal(window, refused=any(attempt.busy for attempt in reply.attempts))
            self._note_reply(window, reply, time.perf_counter() - started)
            return reply
        finally:
            self._release()

    async def _acquire(self) -> None:
        if self._in_flight < self._limit and not self._waiters:
            self._take()
            return
        turn = asyncio.get_running_loop().create_future()
        self._waiters.append(turn)
        try:
            await turn
        except asyncio.CancelledError:
            if turn in self._waiters:
                self._waiters.remove(turn)
            if turn.cancelled():
                self._admit()
            else:  # the slot was handed over before the cancellation arrived
                self._release()
            raise

    def _take(self) -> None:
        self._in_flight += 1
        self._reached = self._reached or self._in_flight >= self._limit

    def _release(self) -> None:
        self._in_flight -= 1
        self._admit()

    def _admit(self) -> None:
        while self._waiters and self._in_flight < self._limit:
            turn = self._waiters.popleft()
            if not turn.cancelled():
                self._take()
                turn.set_result(None)

    def _note_refusal(self, window: int, *, refused: bool) -> None:
        if refused and window == self._window:
            self._doubling = False
            self._set_limit(self._limit // 2)

    def _note_reply(self, window: int, reply: Reply, elapsed_s: float) -> None:
        latency = reply.timings.get("latency", elapsed_s)
        self._least_latency = min(self._least_latency, latency)
        if window != self._window:
            return
        self._latency_s += latency
        self._wait_s += reply.timings.get("queue", latency - self._least_latency)
        self._replies += 1
        if self._replies >= self._limit:
            self._close_window()

    def _close_window(self) -> None:
        """Adapt the limit, unless too few calls were there to reach it: then nothing was learnt."""
        if not self._reached:
            self._open_window()
            return
        queued = self._limit * self._wait_s / self._latency_s if self._latency_s > 0 else 0.0
        self._doubling = self._doubling and queued < ALPHA
        if queued < ALPHA:
            self._set_limit(self._limit * 2 if self._doubling else self._limit + 1)
        elif queued > BETA:
            self._set_limit(self._limit - 1)
        else:
            self._open_window()

    def _set_limit(self, limit: int) -> None:
        self._limit = min(self._max, max(self._min, limit))
        self._open_window()
        self._admit()

    def _open_window(self) -> None:
        self._window += 1
        self._replies = 0
        self._wait_s = 0.0
        self._latency_s = 0.0
        self._reached = False
