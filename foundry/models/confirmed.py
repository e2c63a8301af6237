"""A model whose server is asked again and again whether it still has the weights that the sweep began with."""

from __future__ import annotations

import asyncio
import time

from foundry.errors import InputError, ServerError, TransientError
from foundry.models.base import Model, Reply, Request, UnusableReply
from foundry.models.wrapper import Wrapper

CONFIRM_EVERY_S = 60.0


class ConfirmedModel(Wrapper):
    """Compares the model's digest after a reply that follows a new connection or a failure, and every minute.

    A server that was started anew, perhaps with other weights under the same name, is reached by new connections
    alone; so a reply that follows one is handed on only once the server was asked.
    """

    def __init__(self, inner: Model, digest: str) -> None:
        """Wrap a model whose digest was this when the sweep was checked."""
        super().__init__(inner)
        self._digest = digest
        self._failures, self._settled = 1, 0
        self._unconfirmed = 0
        self._confirmed_at = time.monotonic()
        self._confirming = asyncio.Lock()

    async def ask(self, request: Request) -> Reply:
        """Answer one request.

        Raises:
            ServerError: the server has another model under this name by now.
        """
        try:
            reply = await self.inner.ask(request)
        except UnusableReply:
            raise
        except TransientError as error:
            self._failures += not error.busy
            raise
        self._unconfirmed += 1
        if self._in_doubt:
            async with self._confirming:
                if self._in_doubt:
                    await self._confirm()
        return reply

    async def confirm(self) -> None:
        """Ask the server once more, unless nothing was answered since it was asked last."""
        if self._unconfirmed:
            await self._confirm()

    @property
    def _doubts(self) -> int:
        return self._failures + self.inner.connections

    @property
    def _in_doubt(self) -> bool:
        return self._doubts > self._settled or time.monotonic() - self._confirmed_at >= CONFIRM_EVERY_S

    async def _confirm(self) -> None:
        doubts, unconfirmed = self._doubts, self._unconfirmed
        try:
            digest = (await self.inner.inspect()).digest
        except InputError as error:
            raise TransientError(f"Model '{self.name}' could not be confirmed: {error}") from error
        if digest != self._digest:
            since = time.monotonic() - self._confirmed_at
            raise ServerError(
                f"Model '{self.name}' changed while the sweep ran (digest {self._digest[:12]} when it began, "
                f"{(digest or 'none')[:12]} now); answers of the last {since:.0f} s may be of either. Put the first "
                "one back and resume, or begin a new sweep in another output.dir."
            )
        self._settled, self._confirmed_at = doubts, time.monotonic()
        self._unconfirmed -= unconfirmed
