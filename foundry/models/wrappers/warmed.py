"""A model that is loaded by one call, with a long time-out, before calls fan out."""

from __future__ import annotations

import asyncio

from foundry.models.base import Model, Reply, Request
from foundry.models.wrappers.base import Wrapper


class WarmedModel(Wrapper):
    """Loads the model at the first call; sits under the cache, so a cached sweep never loads anything."""

    def __init__(self, inner: Model) -> None:
        super().__init__(inner)
        self._warm = False
        self._loading = asyncio.Lock()

    async def ask(self, request: Request) -> Reply:
        """Answer one request; the first one waits for the load, and so do all that come meanwhile."""
        if not self._warm:
            async with self._loading:
                if not self._warm:
                    await self.inner.warm_up()
                    self._warm = True
        return await self.inner.ask(request)
