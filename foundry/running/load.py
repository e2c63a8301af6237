"""Makes calls to a server one by one and all at once: how many it processes together, and whether seeds work."""

import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass

from foundry.models.base import Model, Reply, Request, seen_through
from foundry.worlds.base import Answer, unanswered

BURST = 16
"""Number of calls that are sent at once."""
ALONE = 4
"""Number of these calls that are first sent one after another."""


@dataclass(frozen=True)
class Timed:
    """A reply, and the time in which the server worked on it, seconds by the client's clock."""

    reply: Reply
    began: float
    ended: float


async def one_by_one(model: Model, requests: Sequence[Request]) -> list[Timed]:
    """Return the replies to requests, sent one after another."""
    return [await _timed(model, request) for request in requests]


async def at_once(model: Model, requests: Sequence[Request]) -> list[Timed]:
    """Return the replies to requests made together; all calls end before the first error is raised."""
    return await seen_through(_timed(model, request) for request in requests)


async def _timed(model: Model, request: Request) -> Timed:
    """Ask, and record when the server worked on the request, by the server's own account if it gives one."""
    sent = time.perf_counter()
    reply = await model.ask(request)
    ended = time.perf_counter()
    work = reply.timings.get("prompt", 0.0) + reply.timings.get("output", 0.0)
    return Timed(reply, max(sent, ended - work) if work else sent, ended)


@dataclass(frozen=True)
class LoadResult:
    """The results of the measurement.

    Attributes:
        slots: number of calls that the server processed at once; None if this machine was too slow to measure it.
        alone_equal: whether one call gave the same answer twice, without other calls.
        equal_under_load: share of the calls made alone that gave the same answer in the burst.
        alone_s: median seconds of a call without other calls.
        per_call_s: seconds per call in the burst, while all slots of the server are busy.
        prompt_tokens: mean prompt tokens per call; None if the server does not report them.
        output_tokens: mean tokens per reply; None if the server does not report them.
        repeated: number of calls that were repeated before they were answered.
        undecided: number of calls without any text in the reply, or given up by the model.
    """

    slots: int | None
    alone_equal: bool
    equal_under_load: float
    alone_s: float
    per_call_s: float
    prompt_tokens: float | None
    output_tokens: float | None
    calls: int
    repeated: int
    undecided: int


async def measure_load(model: Model, requests: Sequence[Request]) -> LoadResult:
    """Send a few calls one by one, the first call twice; then send all calls at once, including these few."""
    again, *alone = await one_by_one(model, [requests[0], *requests[:ALONE]])
    started, worked = time.perf_counter(), time.process_time()
    burst = await at_once(model, requests)
    elapsed, worked = time.perf_counter() - started, time.process_time() - worked
    same = [one.reply.text == other.reply.text for one, other in zip(alone, burst, strict=False)]
    alone_s = statistics.median(one.ended - one.began for one in alone)
    replies = [one.reply for one in (again, *alone, *burst)]
    slots = None if worked > elapsed / 2 or _is_late(burst) else _slots(burst, alone_s, elapsed)
    return LoadResult(
        slots=slots,
        alone_equal=again.reply.text == alone[0].reply.text,
        equal_under_load=sum(same) / len(same),
        alone_s=alone_s,
        per_call_s=busy_s([one.ended - started for one in burst], slots or 1) / len(requests),
        prompt_tokens=_mean([reply.prompt_tokens for reply in replies]),
        output_tokens=_mean([reply.output_tokens for reply in replies]),
        calls=len(replies),
        repeated=sum(bool(reply.attempts) for reply in replies),
        undecided=sum(unanswered(Answer(reply.text, reply.ending)) is not None for reply in replies),
    )


def busy_s(ends: Sequence[float], slots: int) -> float:
    """Return how long each of the slots was busy, on average: it ends with one of the last calls.

    The last end alone would count the time in which uneven replies leave some slots without a call.

    Args:
        ends: seconds from the start of a burst to the end of each call.
        slots: number of calls that the server processes at once.
    """
    return statistics.fmean(sorted(ends)[-slots:])


def _mean(counts: Sequence[int | None]) -> float | None:
    known = [count for count in counts if count is not None]
    return statistics.fmean(known) if known else None


def _is_late(burst: Sequence[Timed]) -> bool:
    """Return whether replies spent more time on the network than at their server, including its queue."""
    timings = [timed.reply.timings for timed in burst if {"latency", "total"} <= timed.reply.timings.keys()]
    return bool(timings) and statistics.median(seconds["latency"] - 2 * seconds["total"] for seconds in timings) > 0


def _slots(burst: Sequence[Timed], alone_s: float, elapsed_s: float) -> int:
    """Return how many calls overlapped; without the server's times, how much faster the burst was than single calls."""
    if not any("output" in one.reply.timings for one in burst):
        return max(1, round(alone_s * len(burst) / elapsed_s))
    # Overlaps are counted at the middle of a call, since a reply that arrives a little late seems to overlap the next.
    middles = [(one.began + one.ended) / 2 for one in burst]
    overlaps = [sum(one.began <= middle <= one.ended for one in burst) for middle in middles]
    return round(statistics.median(overlaps))
