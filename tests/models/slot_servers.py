"""Servers of models in a time that only their events move on: slots, batches, queues, limits on the calls a second."""

import heapq
import itertools
import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from foundry.models.wrappers.climbing import Climb, Sums

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
