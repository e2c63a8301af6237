"""A model whose server is asked again and again whether it still has the weights that the sweep began with."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

from foundry.errors import HostsDifferError, InputError, TransientError
from foundry.models.answers.unconfirmed import Unconfirmed
from foundry.models.base import Model, Reply, Request, UnusableReply
from foundry.models.wrappers.wrapper import Wrapper

CONFIRM_EVERY_S = 60.0


class ConfirmedModel(Wrapper):
    """Compares what the server is after a reply that follows a new connection or a failure, and every minute.

    A server that was started anew, perhaps with other weights under the same name, is reached by new connections
    alone; so a reply that follows one is handed on only once the server was asked. What a reply itself says of the
    weights is compared at once.
    """

    def __init__(self, inner: Model, unconfirmed: Unconfirmed, *, clock: Callable[[], float] = time.monotonic) -> None:
        """Wrap a model whose answers are kept there; `clock` is the time in seconds."""
        super().__init__(inner)
        self._unconfirmed = unconfirmed
        self._clock = clock
        self._failures, self._settled = 1, 0
        self._confirmed_at = clock()
        self._confirming = asyncio.Lock()

    async def ask(self, request: Request) -> Reply:
        """Answer one request."""
        self._unconfirmed.check()
        try:
            reply = await self.inner.ask(request)
        except UnusableReply:
            raise
        except TransientError as error:
            self._failures += not error.busy
            raise
        self._unconfirmed.check(reply)
        if self._in_doubt:
            async with self._confirming:
                if self._in_doubt:
                    await self._confirm()
        return reply

    async def confirm(self) -> None:
        """Ask the server once more, unless every answer that was used is confirmed."""
        async with self._confirming:
            if self._unconfirmed.any_used:
                await self._confirm()

    @property
    def _doubts(self) -> int:
        return self._failures + self.inner.connections

    @property
    def _in_doubt(self) -> bool:
        return self._doubts > self._settled or self._clock() - self._confirmed_at >= CONFIRM_EVERY_S

    async def _confirm(self) -> None:
        self._unconfirmed.check()
        doubts, moment = self._doubts, self._unconfirmed.moment()
        try:
            info = await self.inner.inspect()
        except HostsDifferError as error:
            raise self._unconfirmed.change(str(error)) from error
        except InputError as error:
            raise TransientError(f"model '{self.name}' could not be confirmed: {error}") from error
        self._unconfirmed.settle(moment, info)
        self._settled, self._confirmed_at = doubts, self._clock()
