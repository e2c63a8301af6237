"""Two wrappers of a model: one answers from the cache, one loads the model before its first call."""

import asyncio
from collections.abc import Sequence

import msgspec

from foundry.models.answers.unconfirmed import Unconfirmed
from foundry.models.base import Model, Reply, Request, seen_through, there
from foundry.models.wrappers.wrapper import Wrapper

MANY = 64
"""With this many calls in flight, a commit waits for more answers, since each commit costs as much as ten rows."""
MOMENT_S = 0.005
"""Time for which a commit waits for more answers, seconds."""


class WarmedModel(Wrapper):
    """Loads the model at its first call. Cached answers need no call, so a fully cached sweep loads no model."""

    def __init__(self, inner: Model) -> None:
        super().__init__(inner)
        self._warm = False
        self._loading = asyncio.Lock()

    async def ask(self, request: Request) -> Reply:
        """Answer one request; the first requests wait until the model is loaded."""
        if not self._warm:
            async with self._loading:
                if not self._warm:
                    await self.inner.warm_up()
                    self._warm = True
        return await self.inner.ask(request)


class CachedModel(Wrapper):
    """Answers from the cache if possible. Several equal requests at the same time cost one call.

    An answer is committed before it is returned, so a killed process loses at most its calls in flight.
    """

    def __init__(self, inner: Model, answers: Unconfirmed) -> None:
        super().__init__(inner)
        self._answers = answers
        self._in_flight: dict[str, asyncio.Future[Reply]] = {}
        self._unsaved: dict[str, tuple[Reply, asyncio.Future[None]]] = {}

    async def ask(self, request: Request) -> Reply:
        """Answer one request from the cache, else from the wrapped model."""
        return (await self.ask_all([request]))[0]

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        """Answer several requests; all requests without a cached answer are asked at the same time."""
        hits = self._answers.find([request.key for request in requests])
        missing = {request.key: request for request in requests if request.key not in hits}
        if not missing:
            return [_marked(hits[request.key]) for request in requests]
        fresh = dict(zip(missing, await seen_through(map(self._ask_once, missing.values())), strict=True))
        return [fresh[r.key] if r.key in fresh else _marked(hits[r.key]) for r in requests]

    def begin(self, requests: Sequence[Request]) -> list[asyncio.Future[Reply]]:
        """Begin to answer several requests; cached answers are available at once."""
        hits = self._answers.find([request.key for request in requests])
        return [
            there(_marked(hits[request.key])) if request.key in hits else asyncio.ensure_future(self._ask_once(request))
            for request in requests
        ]

    async def _ask_once(self, request: Request) -> Reply:
        leader = self._in_flight.get(request.key)
        if leader is not None:
            return _marked(await asyncio.shield(leader))
        future: asyncio.Future[Reply] = asyncio.get_running_loop().create_future()
        self._in_flight[request.key] = future
        try:
            reply = await self.inner.ask(request)
            await self._save(request.key, reply)
        except BaseException as error:
            future.set_exception(error)
            future.exception()  # perhaps no other caller will see it
            raise
        finally:
            del self._in_flight[request.key]
        future.set_result(reply)
        return reply

    def _save(self, key: str, reply: Reply) -> asyncio.Future[None]:
        """Return a future that is done when the reply is stored; replies that arrive together share one commit."""
        loop = asyncio.get_running_loop()
        if not self._unsaved:
            if len(self._in_flight) < MANY:
                loop.call_soon(self._commit)
            else:
                loop.call_later(MOMENT_S, self._commit)
        saved = loop.create_future()  # each has its own future, so that cancelling one cancels no other
        self._unsaved[key] = reply, saved
        return saved

    def _commit(self) -> None:
        unsaved, self._unsaved = self._unsaved, {}
        failure: Exception | None = None
        try:
            self._answers.keep({key: reply for key, (reply, _) in unsaved.items()}, self.name)
        except Exception as error:  # noqa: BLE001 - everyone who waits for the commit gets it
            failure = error
        for _, saved in unsaved.values():
            if saved.done():  # all waiting callers were cancelled
                continue
            if failure is None:
                saved.set_result(None)
            else:
                saved.set_exception(failure)


def _marked(reply: Reply) -> Reply:
    return msgspec.structs.replace(reply, cached=True)
