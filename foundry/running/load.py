"""Requests put to a model one by one and all at once, each with when its server worked on it."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Sequence
from dataclasses import dataclass

from foundry.models.base import Model, Reply, Request


@dataclass(frozen=True)
class Timed:
    """A reply and when the server worked on it, seconds of the client's clock."""

    reply: Reply
    began: float
    ended: float


async def one_by_one(model: Model, requests: Sequence[Request]) -> list[Timed]:
    """Return the replies to requests, each of which waits for the one before it.

    Raises:
        BackendError: the server gave no answer.
    """
    return [await _timed(model, request) for request in requests]


async def at_once(model: Model, requests: Sequence[Request]) -> list[Timed]:
    """Return the replies to requests that are all made together; all are seen through, then the first error is raised.

    Raises:
        BackendError: the server gave no answer.
    """
    found: list[Timed] = []
    for one in await asyncio.gather(*(_timed(model, request) for request in requests), return_exceptions=True):
        if isinstance(one, BaseException):
            raise one
        found.append(one)
    return found


async def _timed(model: Model, request: Request) -> Timed:
    """Ask, and note when the server worked on it: by its own account where it gives one."""
    sent = time.perf_counter()
    reply = await model.ask(request)
    ended = time.perf_counter()
    work = reply.timings.get("prompt", 0.0) + reply.timings.get("output", 0.0)
    return Timed(reply, max(sent, ended - work) if work else sent, ended)
