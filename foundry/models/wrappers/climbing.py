"""Finds the best number of calls in flight for a server by hill climbing on its throughput.

The latency of single calls does not show whether a server is saturated. Replies differ in length, and a batch slows
single replies long before it lowers the total throughput. So two limits on the calls in flight are compared by the
number of answered tokens per second. .NET's thread pool and adaptive concurrency limiters compare limits by throughput
too. A new limit is accepted or rejected once the difference in throughput is larger than its standard error explains.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import msgspec

WORTH_IT = 0.2
"""Minimum relative gain that makes a higher limit worthwhile: gain in throughput per gain in calls in flight."""
LINEAR = 0.6
"""At this relative gain or more, the server has much room left, so the next increase of the limit is larger."""
FLAT = 0.1
"""Below this relative gain, a lower limit loses almost no throughput, so the next decrease of the limit is larger."""
CLEAR = 0.05
"""The throughput at a limit counts as known once the relative error of its measurement is below this value."""
MANY_CALLS = 120
"""A comparison without a result ends after this number of calls; the next one compares limits farther apart."""
COARSE = 0.5
"""Maximum error of a relative gain by which a new limit is accepted or rejected early."""
FIRST_STEP = 4.0
"""Factor of the first increase of the limit. This factor is large, since too many calls in flight for a short time do
little harm.
"""
LARGEST_STEP = 2.0
SMALLEST_STEP = 1.19
LEAST_CALLS = 8
"""Minimum number of answers for a measurement."""
REACHED = 0.25
"""If calls wait for the limit in less than this share of the time, the limit makes no difference."""
MOST_UNACCOUNTED = 0.95
QUEUEING = 1.3
"""Maximum ratio of calls in flight to calls that the server works on. If the calls in flight exceed this maximum by
more than one, the limit falls, since such calls only wait.
"""
REFUSED = 0.3
"""Share of refused tries above which the limit falls."""
ALL_REFUSED = 0.5
"""If at least this share of the tries is refused, the limit is halved at once, even if older calls still run."""


class Sums(msgspec.Struct):
    """Sums over the answered calls of one or more workers. Later sums minus earlier sums describe a period.

    Attributes:
        calls: answered calls.
        work: tokens of these calls, or 1 for a call with unknown tokens.
        seconds: time of these calls in flight.
        work2: sum of squares of `work`.
        seconds2: sum of squares of `seconds`.
        work_seconds: sum of `work` times `seconds`.
        queue_s: time of calls in the server's queue, and other time for which the server does not account, if reported.
        told_s: time in flight of the calls for which the server reports such times.
        in_flight_s: integral of the calls in flight over time.
        waiting_s: time in which calls waited because the limit was reached.
        refused: refused or timed-out calls under the current limit.
        clock_s: elapsed time, summed over workers.
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
        """Add an answered call; `queue_s` is None if the server does not report how long the call waited."""
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
        return Sums(*(mine + two for mine, two in zip(self._values(), other._values(), strict=True)))

    def __sub__(self, other: Sums) -> Sums:
        return Sums(*(mine - two for mine, two in zip(self._values(), other._values(), strict=True)))

    def copy(self) -> Sums:
        """Return a copy of the current sums."""
        return Sums(*self._values())

    def _values(self) -> tuple[float, ...]:
        return msgspec.structs.astuple(self)


@dataclass(frozen=True)
class Measured:
    """The performance of a server over a period.

    Attributes:
        calls: answered calls.
        in_flight: calls in flight on average.
        reached: share of the time in which calls waited because the limit was reached.
        rate: logarithm of the work per second.
        variance: variance of `rate`.
        queued: share of the time in flight in which, by its own clock, the server did not work on a call; None if it
            does not report this.
    """

    calls: float
    in_flight: float
    reached: float
    rate: float
    variance: float
    queued: float | None

    @classmethod
    def of(cls, sums: Sums, workers: int) -> Measured | None:
        """Return the performance over a period, from later sums minus earlier sums; None if nothing was answered.

        By Little's law the rate is the number of calls in flight times the work per second of a call. The work of a
        call grows with its time, so this is far more precise than to count the ended calls.
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
        """Return the exponent a in throughput ~ (calls in flight)^a between two measurements, and its standard error.

        Few calls may agree by chance, so the larger spread of the two measurements applies to both.
        """
        span = math.log(self.in_flight / base.in_flight)
        spread = max(self.calls * self.variance, base.calls * base.variance)
        return (self.rate - base.rate) / span, math.sqrt(spread / self.calls + spread / base.calls) / abs(span) + 1e-9


class Climb:
    """Finds the best limit by trial: it measures throughput at two limits, keeps the better one, and tries again.

    The object gets the sums of the calls whenever they change, and sets `limit`, the allowed calls in flight. At first
    the limit grows fourfold as long as the throughput grows enough. Then the changes of the limit become smaller; later
    the limit goes up and down in turn, with pauses in between. After refusals, timeouts, or a server's report of its
    queue, the limit falls without a comparison.
    """

    def __init__(self, *, least: int, most: int, initial: int, known: bool = False, only_up: bool = False) -> None:
        """Set the smallest, largest and first limit; `known` says that an earlier search ended at the first limit.

        With `only_up`, only refusals and timeouts lower the limit.
        """
        self._only_up = only_up
        self._least = least
        self._most = most
        self.limit = initial
        self._home = initial
        self._base: Measured | None = None
        self._step = math.sqrt(LARGEST_STEP) if known else FIRST_STEP
        self._up = True
        self._failures = 0
        self._rest_calls = float(_long_rest(initial) if known else 0)
        self._settle = float(initial)
        self._judged = 0.0
        self._workers = 1
        self._start = Sums()
        self._climbing = not known
        self._told = False
        self._unaccounted = 0.0

    def look(self, sums: Sums, workers: int = 1) -> None:
        """Change the limit if that helps; `sums` are the latest sums over the calls of all workers."""
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
        """Lower the limit if the server refused too many calls since the last change; return whether it was lowered."""
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

    def _is_known(self, measured: Measured) -> bool:
        return measured.variance < CLEAR**2 or measured.calls >= max(MANY_CALLS, 4 * self.limit)

    def _give_way(self, limit: int, measured: Measured, sums: Sums) -> None:
        """Try this smaller limit, at which hardly any call waits; go back to the earlier limit if it is not smaller."""
        if self._base is not None and limit <= self._home < self.limit:
            self._fail(sums)
            return
        self._up, self._told = False, True
        self._try(limit, measured, sums)

    def _without_waiting(self, measured: Measured) -> int | None:
        """Return a smaller limit at which hardly any call waits in the server's queue; None if few calls wait.

        Time for which the server does not account counts as a queue until a smaller limit lowers the throughput.
        """
        if measured.queued is None or self._only_up:
            return None
        self._unaccounted = min(self._unaccounted, measured.queued)
        at_work = measured.in_flight * (1 - measured.queued) / (1 - self._unaccounted)
        wanted = max(self._floor, math.ceil(1.1 * at_work))
        return wanted if measured.in_flight > QUEUEING * at_work + 1 and wanted < self.limit else None

    def _compare(self, measured: Measured, base: Measured, calls: float, sums: Sums) -> None:
        """Accept or reject the tried limit once the comparison is clear; until then, try limits farther away."""
        if (measured.in_flight > base.in_flight) != self._up or abs(
            math.log(measured.in_flight / base.in_flight)
        ) < 0.02:
            self._told = False
            self._fail(sums)
            return
        gain, error = measured.gain(base)
        sigmas = (gain - WORTH_IT) / error * (1 if self._up else -1)
        largest = self._step >= LARGEST_STEP
        # Too many calls cost little, too few cost throughput: so growth is accepted more readily than shrinking.
        enough, against = (1.5, -2.0) if self._up else (0.0, -2.5) if self._told else (2.0, -1.5)
        most = max(3 * MANY_CALLS, 8 * self.limit) if largest else max(MANY_CALLS, 4 * self.limit)
        if calls < min(most, max(LEAST_CALLS, 3 * base.calls)) and (error > COARSE or against < sigmas < enough):
            return
        # In doubt the server's report of its queue is right.
        if sigmas > (-1.0 if self._told else 0.0 if largest else enough):
            self._take(measured, gain, sums)
        elif sigmas <= against or largest:
            self._fail(sums)
        else:
            self._step = min(LARGEST_STEP, self._step**2)
            self._rest_at(self._home, sums, 0)

    def _take(self, measured: Measured, gain: float, sums: Sums) -> None:
        far = gain > LINEAR if self._up else gain < FLAT
        wider = max(self._step, min(LARGEST_STEP, self._step**2))
        self._step = wider if far else max(SMALLEST_STEP, math.sqrt(self._step))
        self._failures, self._climbing = 0, far and self._up
        if self._told:
            self._step, self._up = math.sqrt(LARGEST_STEP), True
            self._rest_at(self.limit, sums, _long_rest(self.limit))
        else:
            self._home = self.limit
            self._try_another(measured, sums)

    def _fail(self, sums: Sums, *, turns: bool = True) -> None:
        """Go back to about the earlier limit, and try to change it the other way; rest if neither way helps."""
        if self._told and self._base is not None and self._base.queued is not None:
            self._unaccounted = min(MOST_UNACCOUNTED, self._base.queued)  # the wait was not a queue
        if self._climbing and turns and self._step >= LARGEST_STEP:
            self._try_less(sums)
            return
        small = self._step <= SMALLEST_STEP
        self._failures += int(small)
        # A server that reports its queue needs no smaller limit as a test.
        is_told = self._base is not None and self._base.queued is not None
        goes_on = is_told or not turns or (self._climbing and not small)
        self._up, self._climbing = goes_on or not self._up, False
        self._step = max(SMALLEST_STEP, math.sqrt(self._step))
        rest = _long_rest(self._home) * (2 if self._failures >= 4 else 1)
        self._rest_at(self._home, sums, rest if small and (self._failures >= 2 or not turns) else 0)

    def _try_less(self, sums: Sums) -> None:
        """Next, try a limit closer to the earlier limit, whose measured throughput is still valid."""
        self._step = math.sqrt(self._step)
        self._climbing = self._step >= LARGEST_STEP
        self._go_to(min(self._most, round(self._home * self._step)), sums)

    def _fall(self, limit: int, sums: Sums) -> None:
        self._step, self._up, self._failures, self._climbing = math.sqrt(LARGEST_STEP), True, 0, False
        self._rest_at(max(self._least, limit), sums, _long_rest(limit))

    @property
    def _floor(self) -> int:
        """The smallest limit to try: with two calls, the server is busy with one while another is on its way."""
        return max(self._least, min(2, self._most))

    def _try_another(self, base: Measured, sums: Sums) -> None:
        for _ in ("this way", "else the other way"):
            ahead = max(self.limit + 1, round(self.limit * self._step))
            back = self.limit if self._only_up else min(self.limit - 1, round(self.limit / self._step))
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
        """Set a new limit, and measure throughput only after the calls that began under the old limit have ended."""
        self._settle = float(max(self.limit, limit) + abs(limit - self.limit))
        self.limit = limit
        self._start = sums.copy()


def _long_rest(limit: int) -> int:
    return max(120, 12 * limit)
