"""A forked run: the questions before a step are answered from its origin's log, the others by its own model."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from foundry.episode import Asker, Asks
from foundry.models.base import Reply, Request
from foundry.records import Call, Origin
from foundry.running.recorded import RecordedAsker, past_wordings
from foundry.storing.store import SweepFolder, read_calls
from foundry.worlds.base import Question


class ForkedAsker:
    """Hands the questions before a step to one asker and the others to another one."""

    def __init__(self, past: Asks, future: Asks, at: int) -> None:
        self._past = past
        self._future = future
        self._at = at

    def request(self, question: Question) -> Request:
        """Return the request that puts this question."""
        return self._for(question.step).request(question)

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        """Return the replies; the requests of one round belong to one step."""
        return await self._for(requests[0].step).ask_all(requests) if requests else []

    def begin(self, requests: Sequence[Request]) -> list[asyncio.Future[Reply]]:
        """Begin to answer requests, of one step or of several."""
        return [reply for request in requests for reply in self._for(request.step).begin([request])]

    def call(self, request: Request, reply: Reply) -> Call:
        """Return the log line of an answered request."""
        return self._for(request.step).call(request, reply)

    def _for(self, step: int) -> Asks:
        return self._past if step < self._at else self._future


def forked(asker: Asker, config: Mapping[str, Any], folder: SweepFolder) -> Asks:
    """Return the asker of a run, its past recorded where the run is a fork.

    Raises:
        RecordError: the log of the past cannot be read.
    """
    if "fork" not in config:
        return asker
    fork = config["fork"]
    calls = read_calls(folder.origin_path(fork["run"], fork["at"]))
    return ForkedAsker(RecordedAsker(calls, past_wordings(config)), asker, fork["at"])


def origin_of(config: Mapping[str, Any]) -> Origin | None:
    """Return where a run was forked from, or None when it was not."""
    if "fork" not in config:
        return None
    return msgspec.convert({key: value for key, value in config["fork"].items() if key != "past"}, Origin)
