"""Calls put to a server one by one and all at once: how many it works on together, and whether seeds hold."""

import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass

from foundry.models.base import Model, Reply, Request, seen_through
from foundry.worlds.base import Answer, unanswered

BURST = 16
"""Calls sent at once."""
ALONE = 4
"""The first of them, which are sent one after another before."""


@dataclass(frozen=True)
class Timed:
    """A reply and when the server worked on it, seconds of the client's clock."""

    reply: Reply
    began: float
    ended: float


async def one_by_one(model: Model, requests: Sequence[Request]) -> list[Timed]:
    """Return the replies to requests, sent one after another."""
    return [await _timed(model, request) for request in requests]


async def at_once(model: Model, requests: Sequence[Request]) -> list[Timed]:
    """Return the replies to requests made together; all are seen through, then the first error is raised."""
    return await seen_through(_timed(model, request) for request in requests)


async def _timed(model: Model, request: Request) -> Timed:
    """Ask, and note when the server worked on it: by its own account where it gives one."""
    sent = time.perf_counter()
    reply = await model.ask(request)
    ended = time.perf_counter()
    work = reply.timings.get("prompt", 0.0) + reply.timings.get("output", 0.0)
    return Timed(reply, max(sent, ended - work) if work else sent, ended)


@dataclass(frozen=True)
class LoadResult:
    """What was measured.

    Attributes:
        slots: calls that the server worked on at once; None where this machine was too slow to tell.
        alone_equal: whether the same call gave the same answer twice, one at a time.
        equal_under_load: share of the same calls in a burst that gave that answer, too.
        alone_s: seconds of a call by itself, the median.
        per_call_s: seconds per call in the burst.
        prompt_tokens: of a call, on average; None where the server does not tell.
        output_tokens: of a reply, on average; None where the server does not tell.
        calls: calls that were made.
        repeated: those that had to be made again before they were answered.
        undecided: those that the model left without anything to read, or gave up.
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
    """Send a few calls alone, the first one twice, then all of them at once, the same few among them."""
    again, *alone = await one_by_one(model, [requests[0], *requests[:ALONE]])
    started, worked = time.perf_counter(), time.process_time()
    burst = await at_once(model, requests)
    elapsed, worked = time.perf_counter() - started, time.process_time() - worked
    same = [one.reply.text == other.reply.text for one, other in zip(alone, burst, strict=False)]
    alone_s = statistics.median(one.ended - one.began for one in alone)
    replies = [one.reply for one in (again, *alone, *burst)]
    return LoadResult(
        slots=None if worked > elapsed / 2 or _is_late(burst) else _slots(burst, alone_s, elapsed),
        alone_equal=again.reply.text == alone[0].reply.text,
        equal_under_load=sum(same) / len(same),
        alone_s=alone_s,
        per_call_s=elapsed / len(requests),
        prompt_tokens=_mean([reply.prompt_tokens for reply in replies]),
        output_tokens=_mean([reply.output_tokens for reply in replies]),
        calls=len(replies),
        repeated=sum(bool(reply.attempts) for reply in replies),
        undecided=sum(unanswered(Answer(reply.text, reply.ending)) is not None for reply in replies),
    )


def _mean(counts: Sequence[int | None]) -> float | None:
    known = [count for count in counts if count is not None]
    return statistics.fmean(known) if known else None


def _is_late(burst: Sequence[Timed]) -> bool:
    """Return whether replies took longer on their way to us than their server took for them, its queue included."""
    timings = [timed.reply.timings for timed in burst if {"latency", "total"} <= timed.reply.timings.keys()]
    return bool(timings) and statistics.median(seconds["latency"] - 2 * seconds["total"] for seconds in timings) > 0


def _slots(burst: Sequence[Timed], alone_s: float, elapsed_s: float) -> int:
    """Return how many calls overlapped; without the server's account, how much faster the burst was than one by one."""
    if not any("output" in one.reply.timings for one in burst):
        return max(1, round(alone_s * len(burst) / elapsed_s))
    # In the middle of a call, since a reply that arrives a little late seems to overlap the next one at its end.
    middles = [(one.began + one.ended) / 2 for one in burst]
    overlaps = [sum(one.began <= middle <= one.ended for one in burst) for middle in middles]
    return round(statistics.median(overlaps))
