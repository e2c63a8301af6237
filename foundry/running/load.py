"""Measures a server by calls, one by one and all at once: how many it processes together, and whether seeds work."""

import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass

from foundry.models.base import Model, Reply, Request, seen_through
from foundry.worlds.base import Answer, unanswered

BURST = 16
"""Number of calls that are sent at the same time."""
ALONE = 4
"""Number of calls that are sent one after another, before the calls that are sent at the same time."""


@dataclass(frozen=True)
class TimedReply:
    """A reply, and the times at which the server began and ended its work on it, seconds by this machine's clock."""

    reply: Reply
    began: float
    ended: float


async def one_by_one(model: Model, requests: Sequence[Request]) -> list[TimedReply]:
    """Send requests one after another, and return the replies."""
    return [await _timed(model, request) for request in requests]


async def at_once(model: Model, requests: Sequence[Request]) -> list[TimedReply]:
    """Send requests at the same time, and return the replies; after an error, wait for all other replies first."""
    return await seen_through(_timed(model, request) for request in requests)


async def _timed(model: Model, request: Request) -> TimedReply:
    """Send a request and measure its time, or take the working time that the server reports."""
    sent = time.perf_counter()
    reply = await model.ask(request)
    ended = time.perf_counter()
    work = reply.timings.get("prompt", 0.0) + reply.timings.get("output", 0.0)
    return TimedReply(reply, max(sent, ended - work) if work else sent, ended)


@dataclass(frozen=True)
class LoadResult:
    """The measured behaviour of a server, for calls one by one and all at once.

    Attributes:
        slots: number of calls that the server processed at once; None if this machine was too slow to measure it.
        alone_equal: whether a call that was sent twice, alone, got the same answer twice.
        equal_under_load: share of the calls that got the same answer alone and together with all others.
        alone_s: median time of a call that is sent alone, seconds.
        per_call_s: time per call while all slots of the server are busy, seconds.
        prompt_tokens: mean number of tokens of a prompt; None if the server does not report it.
        output_tokens: mean number of tokens of a reply; None if the server does not report it.
        repeated: number of calls that failed first and were then repeated.
        undecided: number of calls with an empty reply, or that the model gave up.
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
    """Send the first calls one by one, the very first of them twice; then send all calls at the same time."""
    again, *alone = await one_by_one(model, [requests[0], *requests[:ALONE]])
    started, worked = time.perf_counter(), time.process_time()
    burst = await at_once(model, requests)
    elapsed, worked = time.perf_counter() - started, time.process_time() - worked
    same = [timed.reply.text == other.reply.text for timed, other in zip(alone, burst, strict=False)]
    alone_s = statistics.median(timed.ended - timed.began for timed in alone)
    replies = [timed.reply for timed in (again, *alone, *burst)]
    slots = None if worked > elapsed / 2 or _is_late(burst) else _slots(burst, alone_s, elapsed)
    return LoadResult(
        slots=slots,
        alone_equal=again.reply.text == alone[0].reply.text,
        equal_under_load=sum(same) / len(same),
        alone_s=alone_s,
        per_call_s=busy_s([timed.ended - started for timed in burst], slots or 1) / len(requests),
        prompt_tokens=_mean([reply.prompt_tokens for reply in replies]),
        output_tokens=_mean([reply.output_tokens for reply in replies]),
        calls=len(replies),
        repeated=sum(bool(reply.attempts) for reply in replies),
        undecided=sum(unanswered(Answer(reply.text, reply.ending)) is not None for reply in replies),
    )


def busy_s(ends: Sequence[float], slots: int) -> float:
    """Return how long a slot of a server was busy on average, seconds.

    For n slots, this is the mean end of the last n calls. When the very last call ends, the other slots are idle.

    Args:
        ends: time from the start of all calls to the end of each call, seconds.
        slots: number of calls that the server processes at once.
    """
    return statistics.fmean(sorted(ends)[-slots:])


def _mean(counts: Sequence[int | None]) -> float | None:
    known = [count for count in counts if count is not None]
    return statistics.fmean(known) if known else None


def _is_late(burst: Sequence[TimedReply]) -> bool:
    """Return whether the median reply took more time on the network than at its server (waiting time included)."""
    timings = [timed.reply.timings for timed in burst if {"latency", "total"} <= timed.reply.timings.keys()]
    return bool(timings) and statistics.median(seconds["latency"] - 2 * seconds["total"] for seconds in timings) > 0


def _slots(burst: Sequence[TimedReply], alone_s: float, elapsed_s: float) -> int:
    """Return how many calls a server worked on at once: from the times that it reports, else from the gained time."""
    if not any("output" in timed.reply.timings for timed in burst):
        return max(1, round(alone_s * len(burst) / elapsed_s))
    # Overlaps are counted at the middle of a call, since a reply that arrives a little late seems to overlap the next.
    middles = [(timed.began + timed.ended) / 2 for timed in burst]
    overlaps = [sum(timed.began <= middle <= timed.ended for timed in burst) for middle in middles]
    return round(statistics.median(overlaps))
