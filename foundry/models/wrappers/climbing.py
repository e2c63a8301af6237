"""How many calls a server should have in flight: a climb along its throughput, read from sums over answered calls.

The knee of a server's throughput cannot be seen in the latency of single calls: replies differ in length, and a batch
makes each of them slower long before it makes all of them slower. So limits are compared by what they are for, tokens
answered a second, as the hill climbing of .NET's thread pool and adaptive concurrency limiters do; a step is decided
once the difference stands out of the noise, which is estimated from the same calls.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import msgspec

WORTH_IT = 0.2
"""A share more calls in flight must answer at least this part of that share more."""
LINEAR = 0.6
"""From here on the server is far from its limit, and steps grow."""
FLAT = 0.1
CLEAR = 0.05
"""A throughput that is known to this share needs no more calls."""
MANY_CALLS = 120
"""After so many calls an open question is left, and asked again in another way."""
COARSE = 0.5
"""A gain that is known no better than this decides nothing yet."""
FIRST_STEP = 4.0
"""From the start the limit grows so fast: too many calls in flight for a moment cost less than too few."""
LARGEST_STEP = 2.0
SMALLEST_STEP = 1.19
LEAST_CALLS = 8
"""Fewer answers say nothing."""
REACHED = 0.25
"""Where calls waited for the limit for less than this share of the time, nothing can be learnt of it."""
MOST_UNACCOUNTED = 0.95
QUEUEING = 1.3
"""In flight over at work by the server's own clock; beyond it (and one more) calls only wait, and the limit falls."""
REFUSED = 0.3
"""The limit falls when more than this share of the tries is refused."""
ALL_REFUSED = 0.5
"""It falls to half when it is even this share, and before what was in flight by an earlier limit is over."""


class Sums(msgspec.Struct):
    """Sums over what one or more workers have had answered; differences of them tell of the time between.

    Attributes:
        calls: answered calls.
        work: their tokens, or calls where tokens are unknown.
        seconds: their time in flight.
        work2: sum of squares of `work`.
        seconds2: sum of squares of `seconds`.
        work_seconds: sum of products of both.
        queue_s: their time in the server's queue and whatever else it does not account for, where it tells.
        told_s: time in flight of those whose server tells.
        in_flight_s: integral of the calls in flight over time.
        waiting_s: time that calls waited because as many as allowed were in flight.
        refused: calls that were refused or timed out, by a limit that still stands.
        clock_s: the time of each worker's clock.
    """

    calls: float = 0.0
    work: float = 0.0
    seconds: float = 0.0
    work2: float = 0.0
    seconds2: float = 0.0
    work_seconds: float = 0.0
    queue_s: float = 0.0
    told_s: float = 0.0
    in_flight_s: float = 0.0
    waiting_s: float = 0.0
    refused: float = 0.0
    clock_s: float = 0.0

    def note(self, work: float, seconds: float, queue_s: float | None) -> None:
        """Add an answered call; `queue_s` is None where the server does not tell."""
        self.calls += 1
        self.work += work
        self.seconds += seconds
        self.work2 += work * work
        self.seconds2 += seconds * seconds
        self.work_seconds += work * seconds
        if queue_s is not None:
            self.queue_s += queue_s
            self.told_s += seconds

    def __add__(self, other: Sums) -> Sums:
        return Sums(*(one + two for one, two in zip(self._values(), other._values(), strict=True)))

    def __sub__(self, other: Sums) -> Sums:
        return Sums(*(one - two for one, two in zip(self._values(), other._values(), strict=True)))

    def copy(self) -> Sums:
        """Return the sums as they are now."""
        return Sums(*self._values())

    def _values(self) -> tuple[float, ...]:
        return msgspec.structs.astuple(self)


@dataclass(frozen=True)
class Measured:
    """What a server did in a stretch of time.

    Attributes:
        calls: answered calls.
        in_flight: calls in flight on average.
        reached: share of the time that calls waited because as many as allowed were in flight.
        rate: logarithm of the work per second.
        variance: of `rate`.
        queued: share of the calls' time that they were not worked on, by the server's clock; None where it is silent.
    """

    calls: float
    in_flight: float
    reached: float
    rate: float
    variance: float
    queued: float | None

    @classmethod
    def of(cls, sums: Sums, workers: int) -> Measured | None:
        """Return what a difference of sums says; None where nothing was done.

        The rate is by Little's law: calls in flight times work per second of a call. Long replies take long, so that
        this is known far better than how many calls ended.
        """
        if min(sums.work, sums.seconds, sums.in_flight_s, sums.clock_s) <= 0:
            return None
        speed = sums.work / sums.seconds
        residuals = max(0.0, sums.work2 - 2 * speed * sums.work_seconds + speed**2 * sums.seconds2)
        in_flight = sums.in_flight_s / sums.clock_s * workers
        queued = sums.queue_s / sums.told_s if sums.told_s > 0 else None
        reached, rate = sums.waiting_s / sums.clock_s, math.log(speed * in_flight)
        return cls(sums.calls, in_flight, reached, rate, residuals / sums.work**2, queued)

    def gain(self, base: Measured) -> tuple[float, float]:
        """Return by which power of the calls in flight the throughput differs from another's, and its error.

        Few calls may agree by chance, so that their spread is taken to be at least that of the others.
        """
        span = math.log(self.in_flight / base.in_flight)
        spread = max(self.calls * self.variance, base.calls * base.variance)
        return (self.rate - base.rate) / span, math.sqrt(spread / self.calls + spread / base.calls) / abs(span) + 1e-9


class Climb:
    """Finds a limit by trying: rests at one, measures, tries another, and takes the better one.

    It is told the sums so far, whenever they are known anew, and says by `limit` how many calls may be in flight. From
    the start it grows fourfold while that pays; when it does not, it tries ever smaller steps, and later up and down in
    turn, with rests in between. Refusals, time-outs and what the server says of its queue need no comparison.
    """

    def __init__(self, *, least: int, most: int, initial: int, found: bool = False) -> None:
        """Set the bounds, and where to start; `found` says that this limit was found before."""
        self._least = least
        self._most = most
        self.limit = initial
        self._home = initial
        self._base: Measured | None = None
        self._step = math.sqrt(LARGEST_STEP) if found else FIRST_STEP
        self._up = True
        self._failures = 0
        self._rest_calls = float(_long_rest(initial) if found else 0)
        self._settle = 0.0
        self._judged = 0.0
        self._workers = 1
        self._start = Sums()
        self._climbing = not found
        self._told = False
        self._unaccounted = MOST_UNACCOUNTED

    def look(self, sums: Sums, workers: int = 1) -> None:
        """Take up the sums over the calls of so many workers, and change the limit if they say so."""
        if workers != self._workers:
            self._workers = workers
            self._rest_at(self._home, sums, self._rest_calls)
        if self._is_refused(sums):
            return
        if self._settle and sums.calls - self._start.calls >= self._settle:
            self._start, self._settle = sums.copy(), 0.0
        calls = sums.calls - self._start.calls
        if self._settle or calls < max(min(LEAST_CALLS, 2 * self.limit), self.limit):
            return
        if sums.calls - self._judged >= self.limit / 16:  # not at every call, which would cost time
            self._judged = sums.calls
            self._judge(calls, sums)

    def _is_refused(self, sums: Sums) -> bool:
        """Fall where too many calls were refused since the last change."""
        refused, calls = sums.refused - self._start.refused, sums.calls - self._start.calls
        share = refused / max(1, calls + refused)
        if refused < min(4, self.limit) or calls + refused < self.limit / 2:
            return False
        if share < (ALL_REFUSED if self._settle else REFUSED):
            return False
        if self._base is not None and self.limit > self._home:
            self._fail(sums, turns=False)
        else:
            self._fall(int(self.limit * (0.5 if share >= ALL_REFUSED else 0.9)), sums)
        return True

    def _judge(self, calls: float, sums: Sums) -> None:
        measured = Measured.of(sums - self._start, self._workers)
        if measured is None or measured.reached < REACHED:
            self._start = sums.copy()
        elif (waitless := self._without_waiting(measured)) is not None:
            self._give_way(waitless, measured, sums)
        elif self._base is not None:
            self._compare(measured, self._base, calls, sums)
        elif calls >= self._rest_calls and self._is_known(measured):
            self._try_another(measured, sums)

    def _is_known(self, found: Measured) -> bool:
        """Return whether enough is known of the throughput here to compare another one with it."""
        return found.variance < CLEAR**2 or found.calls >= max(MANY_CALLS, 4 * self.limit)

    def _give_way(self, limit: int, found: Measured, sums: Sums) -> None:
        """Try the limit at which hardly a call waits, or go back where that is no more than before."""
        if self._base is not None and limit <= self._home < self.limit:
            self._fail(sums)
            return
        self._up, self._told = False, True
        self._try(limit, found, sums)

    def _without_waiting(self, found: Measured) -> int | None:
        """Return a limit at which hardly a call waits in the server's queue, where too many do.

        What a server does not account for is no queue as long as it was there at the least load seen.
        """
        if found.queued is None:
            return None
        self._unaccounted = min(self._unaccounted, found.queued)
        at_work = found.in_flight * (1 - found.queued) / (1 - self._unaccounted)
        wanted = max(self._floor, math.ceil(1.1 * at_work))
        return wanted if found.in_flight > QUEUEING * at_work + 1 and wanted < self.limit else None

    def _compare(self, found: Measured, base: Measured, calls: float, sums: Sums) -> None:
        """Take the limit that is tried, or leave it, once it is clear which; look again with a larger step if not."""
        if (found.in_flight > base.in_flight) != self._up or abs(math.log(found.in_flight / base.in_flight)) < 0.02:
            self._told = False
            self._fail(sums)
            return
        gain, error = found.gain(base)
        sigmas = (gain - WORTH_IT) / error * (1 if self._up else -1)
        largest = self._step >= LARGEST_STEP
        # More calls than needed cost little, fewer cost throughput: growing is taken more readily than shrinking.
        enough, against = (1.5, -2.0) if self._up else (0.0, -2.5) if self._told else (2.0, -1.5)
        most = max(3 * MANY_CALLS, 8 * self.limit) if largest else max(MANY_CALLS, 4 * self.limit)
        if calls < min(most, max(LEAST_CALLS, 3 * base.calls)) and (error > COARSE or against < sigmas < enough):
            return
        if sigmas >= enough or (largest and sigmas > 0):
            self._take(found, gain, sums)
        elif sigmas <= against or largest:
            self._fail(sums)
        else:
            self._step = min(LARGEST_STEP, self._step**2)
            self._rest_at(self._home, sums, 0)

    def _take(self, found: Measured, gain: float, sums: Sums) -> None:
        """Stay at the limit that was tried, and try the next one in the same direction."""
        far = gain > LINEAR if self._up else gain < FLAT
        wider = max(self._step, min(LARGEST_STEP, self._step**2))
        self._step = wider if far else max(SMALLEST_STEP, math.sqrt(self._step))
        self._failures, self._climbing = 0, far and self._up
        if self._told:
            self._step, self._up = math.sqrt(LARGEST_STEP), True
            self._rest_at(self.limit, sums, _long_rest(self.limit))
        else:
            self._home = self.limit
            self._try_another(found, sums)

    def _fail(self, sums: Sums, *, turns: bool = True) -> None:
        """Go back to the limit before, or near it, and turn round; when neither direction pays, rest for long."""
        if self._told and self._base is not None and self._base.queued is not None:
            self._unaccounted = min(MOST_UNACCOUNTED, self._base.queued)  # it was no queue
        if self._climbing and turns and self._step >= LARGEST_STEP:
            self._try_less(sums)
            return
        small = self._step <= SMALLEST_STEP
        self._failures += int(small)
        # A server that tells of its queue need not be given too little to see whether it was given too much.
        is_told = self._base is not None and self._base.queued is not None
        goes_on = is_told or not turns or (self._climbing and not small)
        self._up, self._climbing = goes_on or not self._up, False
        self._step = max(SMALLEST_STEP, math.sqrt(self._step))
        rest = _long_rest(self._home) * (2 if self._failures >= 4 else 1)
        self._rest_at(self._home, sums, rest if small and (self._failures >= 2 or not turns) else 0)

    def _try_less(self, sums: Sums) -> None:
        """Try a smaller step from the limit before, whose measurement still holds and which may be far too low."""
        self._step = math.sqrt(self._step)
        self._climbing = self._step >= LARGEST_STEP
        self._go_to(min(self._most, round(self._home * self._step)), sums)

    def _fall(self, limit: int, sums: Sums) -> None:
        """Go down at once, and grow again from there with care."""
        self._step, self._up, self._failures, self._climbing = math.sqrt(LARGEST_STEP), True, 0, False
        self._rest_at(max(self._least, limit), sums, _long_rest(limit))

    @property
    def _floor(self) -> int:
        """The least that is tried: while one call is on its way, another one is worked on."""
        return max(self._least, min(2, self._most))

    def _try_another(self, base: Measured, sums: Sums) -> None:
        for _ in ("this way", "else the other way"):
            ahead = max(self.limit + 1, round(self.limit * self._step))
            back = min(self.limit - 1, round(self.limit / self._step))
            tried = max(self._floor, min(self._most, ahead if self._up else back))
            if tried != self.limit:
                self._try(tried, base, sums)
                return
            self._up = not self._up
        self._rest_at(self.limit, sums, _long_rest(self.limit))

    def _try(self, limit: int, base: Measured, sums: Sums) -> None:
        self._home, self._base = self.limit, base
        self._go_to(limit, sums)

    def _rest_at(self, limit: int, sums: Sums, calls: float) -> None:
        self._told = False
        self._home, self._base, self._rest_calls = limit, None, calls
        self._go_to(limit, sums)

    def _go_to(self, limit: int, sums: Sums) -> None:
        """Change the limit; what is in flight by the old one, or comes before all others are, is waited out first."""
        self._settle = float(max(self.limit, limit) + abs(limit - self.limit))
        self.limit = limit
        self._start = sums.copy()


def _long_rest(limit: int) -> int:
    return max(120, 12 * limit)
