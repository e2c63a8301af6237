"""Servers of models in a time that only their events move on: slots, batches, queues, limits on the calls a second."""

import asyncio
import heapq
import itertools
import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import msgspec
import numpy as np

from foundry.models.http.transport import Response
from foundry.models.ollama.ollama_model import OllamaModel
from foundry.models.serving import InFlight
from foundry.models.wrappers.climbing import Climb, Sums
from foundry.models.wrappers.limited import Limit

PACE = 2
"""Calls that wait for the limit and may follow one answer; those that come while there is room go at once."""


@dataclass
class Timed:
    """A server, and clients that always have one more call for it."""

    slots: int
    seed: int = 0
    spread: float = 0.6
    slowdown: Callable[[int], float] = lambda batch: 1.0
    tells_queue: bool = False
    overhead: float = 0.0
    tells_tokens: bool = True
    per_unit: float = math.inf
    changes: dict[int, int] = field(default_factory=dict)
    runs: int = 0

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)
        self.sums = Sums()
        self.answered = 0
        self.refused = 0
        self.most_queued = 0
        self.ends: list[float] = []
        self._events: list[tuple[float, int, str, list[float]]] = []
        self._numbers = itertools.count()
        self._active: list[tuple[float, int, list[float]]] = []
        self._queue: deque[list[float]] = deque()
        self._done = 0.0
        self._allowance, self._allowed_at = 10.0, 0.0
        self._left = {run: 20 for run in range(self.runs)}
        self._todo = deque(run for run in self._left for _ in range(20))
        self._in_flight = 0
        self._came = False

    @property
    def now(self) -> float:
        return self.sums.clock_s

    def serve(self, calls: int, climb: Climb | None = None, fixed: int = 0) -> None:
        """Answer so many more calls, by a limit that is found or a fixed one."""
        limit = (lambda: fixed) if climb is None else (lambda: climb.limit)
        self._send(limit(), limit())
        for _ in range(calls):
            while (kind := self._next_event()) != "end":
                if kind == "refused":
                    self.sums.refused += 1
                    self._look(climb)
            self._look(climb)
            self._send(limit(), limit() if self._came else PACE)
            self._came = False

    def rate(self, calls: int) -> float:
        return calls / (self.now - self.ends[-calls - 1])

    def _look(self, climb: Climb | None) -> None:
        if climb is not None:
            climb.look(self.sums)

    def _send(self, limit: int, most: int) -> None:
        for _ in range(most):
            if self._in_flight < limit and (self._todo or not self.runs):
                run = float(self._todo.popleft()) if self.runs else 0.0
                work = float(self.rng.lognormal(-(self.spread**2) / 2, self.spread))
                self._in_flight += 1
                self._push(self.overhead, "arrives", [self.now, work, run, 0.0])

    def _push(self, delay: float, kind: str, call: list[float]) -> None:
        heapq.heappush(self._events, (self.now + delay, next(self._numbers), kind, call))

    def _next_event(self) -> str:
        batch = len(self._active)
        pace = 1 / self.slowdown(batch) if batch else 0.0
        ends = self.now + (self._active[0][0] - self._done) / pace if batch else math.inf
        at = min(ends, self._events[0][0] if self._events else math.inf)
        self._pass(at - self.now, pace)
        kind = self._end(heapq.heappop(self._active)[2]) if ends == at else self._arrive(heapq.heappop(self._events)[3])
        slots = next((n for after, n in self.changes.items() if self.answered >= after), self.slots)
        while self._queue and len(self._active) < slots:
            call = self._queue.popleft()
            call[3] = self.now - call[0]
            heapq.heappush(self._active, (self._done + call[1], next(self._numbers), call))
        self.most_queued = max(self.most_queued, len(self._queue))
        return kind

    def _pass(self, time: float, pace: float) -> None:
        self._done += time * pace
        self.sums.clock_s += time
        self.sums.in_flight_s += time * self._in_flight
        self.sums.waiting_s += time if self._todo or not self.runs else 0.0

    def _arrive(self, call: list[float]) -> str:
        passed, self._allowed_at = self.now - self._allowed_at, self.now
        self._allowance = min(10.0, self._allowance + passed * self.per_unit)
        if self._allowance < 1:
            self.refused += 1
            self._push(float(self.rng.uniform(0.25, 0.5)), "arrives", call)
            return "refused"
        self._allowance -= 1
        self._queue.append(call)
        return "arrives"

    def _end(self, call: list[float]) -> str:
        self._in_flight -= 1
        self.answered += 1
        self.ends.append(self.now)
        if self.runs:
            self._left[int(call[2])] -= 1
            if not self._left[int(call[2])]:
                self._left[int(call[2])] = 20
                self._todo.extend([int(call[2])] * 20)
                self._came = True
        queue = call[3] if self.tells_queue else None
        self.sums.note(100 * call[1] if self.tells_tokens else 1, self.now - call[0], queue)
        return "end"


class Unhurried:
    """Hands real servers' replies to a model when servers of slots would, once all in flight have theirs."""

    SETTLED = 20
    """Turns of the event loop after which nobody has anything to do but to wait."""

    def __init__(
        self, model: OllamaModel, bounds: InFlight, *, slots: int, work: Callable[[int], float] = lambda seed: 1.0
    ) -> None:
        self.now, self.most = 0.0, 0
        self.limit = Limit(bounds, clock=lambda: self.now)
        self._slots, self._work = slots, work
        self._send, model._transport.send = model._transport.send, self.send  # type: ignore[method-assign]
        self._free: dict[str, list[float]] = {}
        self._numbers = itertools.count()
        self._due: list[tuple[float, int, asyncio.Future[None]]] = []
        self._moving: asyncio.Task[None] | None = None

    async def send(self, origin: Any, method: str, path: str, *, content: bytes, **named: Any) -> Response:
        """Send one call, and return its reply once it is due, with the times that go with that."""
        self.most = max(self.most, self.limit.in_flight)
        asked, number, free = self.now, next(self._numbers), self._free.setdefault(origin.host, [0.0] * self._slots)
        work = self._work(msgspec.json.decode(content)["options"]["seed"])
        due = max(asked, heapq.heappop(free)) + work
        heapq.heappush(free, due)
        response = await self._send(origin, method, path, content=content, **named)
        turn = asyncio.get_running_loop().create_future()
        heapq.heappush(self._due, (due, number, turn))
        if self._moving is None or self._moving.done():
            self._moving = asyncio.create_task(self._move_on())
        await turn
        told = {"total_duration": int((due - asked) * 1e9), "eval_duration": int(work * 1e9)}
        return replace(response, content=msgspec.json.encode({**msgspec.json.decode(response.content), **told}))

    async def _move_on(self) -> None:
        while True:
            for _ in range(self.SETTLED):
                await asyncio.sleep(0)
            if not self._due or len(self._due) < self.limit.in_flight:
                return
            self.now, _, turn = heapq.heappop(self._due)
            turn.set_result(None)
