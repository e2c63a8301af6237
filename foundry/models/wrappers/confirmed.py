"""Checks again and again that a server still has the weights with which the sweep started."""

import asyncio
import time
from collections.abc import Callable
from typing import NamedTuple

from foundry import seeding
from foundry.canary import Canary
from foundry.errors import HostsDifferError, InputError, TransientError
from foundry.models.answers.known_weights import with_weights
from foundry.models.answers.unconfirmed import Unconfirmed
from foundry.models.base import Model, ModelInfo, Reply, Request, UnusableReply
from foundry.models.wrappers.canaries import CanaryWatch
from foundry.models.wrappers.wrapper import Wrapper

CONFIRM_EVERY_S = 60.0
CONFIRM_EVERY_CALLS = 100
"""In each group of this many calls, a random one causes a check, to find weights that are replaced for a short time."""
FREE_CONFIRMATIONS, CALLS_A_CONFIRMATION = 32, 20
"""The first 32 new connections each cause a check; later ones do so only once per 20 calls."""


class Doubts(NamedTuple):
    """Counts of events that make a check of the server necessary, such as new connections.

    Attributes:
        raised: failures, and calls chosen at random.
        connections: connections that were opened.
    """

    raised: int
    connections: int


class ConfirmedModel(Wrapper):
    """Checks the server's weights after a new connection or a failure, every minute, and after random calls.

    A check compares the server's facts about the model, and its answers to canary calls. The canary decides if the
    server reports no digest; otherwise a difference is only logged.

    A server that was restarted, perhaps with other weights under its name, has new connections. So foundry returns a
    reply over a new connection only after a check of the server's weights. Facts about weights in a reply are compared
    at once.
    """

    def __init__(
        self,
        inner: Model,
        unconfirmed: Unconfirmed,
        info: ModelInfo,
        watch: CanaryWatch | None = None,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Wrap a model.

        Args:
            inner: wrapped model.
            unconfirmed: answers of the model.
            info: facts about the model.
            watch: makes the canary calls; None if the model has no canary.
            clock: function that returns the time, seconds.
        """
        super().__init__(inner)
        self._info = info
        self._watch = watch
        self._calls = self._drawn = 0
        self._unconfirmed = unconfirmed
        self._clock = clock
        self._raised, self._settled = 1, Doubts(0, 0)
        self._confirmations = 0
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
            self._raised += not error.busy
            raise
        self._unconfirmed.check(reply)
        self._draw(request)
        if self._in_doubt:
            async with self._confirming:
                if self._in_doubt:
                    await self._confirm()
        return reply

    def canaries(self) -> tuple[Canary, ...]:
        """Return the results of the canary calls, which show whether the weights changed."""
        record = None if self._watch is None else self._watch.record()
        return () if record is None else (record,)

    async def confirm(self) -> None:
        """Check the server once more, unless all answers that this process used are confirmed already."""
        async with self._confirming:
            if self._unconfirmed.any_used:
                await self._confirm()

    @property
    def _doubts(self) -> Doubts:
        return Doubts(self._raised, self.inner.connections)

    @property
    def _in_doubt(self) -> bool:
        if self._raised > self._settled.raised or self._clock() - self._confirmed_at >= CONFIRM_EVERY_S:
            return True
        are_rare = self._confirmations <= FREE_CONFIRMATIONS + self._calls // CALLS_A_CONFIRMATION
        return are_rare and self.inner.connections > self._settled.connections

    def _draw(self, request: Request) -> None:
        """Count a call; in each hundred calls, a random one causes a check, drawn with the seed of the first call."""
        place = self._calls % CONFIRM_EVERY_CALLS
        if place == 0:
            self._drawn = int(seeding.stream(request.seed, "canary").integers(CONFIRM_EVERY_CALLS))
        self._calls += 1
        self._raised += self._watch is not None and place == self._drawn

    async def _confirm(self) -> None:
        self._unconfirmed.check()
        doubts, moment = self._doubts, self._unconfirmed.moment()
        try:
            info = await self.inner.inspect()
        except HostsDifferError as error:
            raise self._unconfirmed.change(str(error)) from error
        except InputError as error:
            raise TransientError(f"The weights of model '{self.name}' could not be checked: {error}") from error
        await self._check_canary()
        self._unconfirmed.settle(moment, with_weights(info, self._info.digest or ""))
        self._settled, self._confirmed_at = doubts, self._clock()
        self._confirmations += 1

    async def _check_canary(self) -> None:
        how = None if self._watch is None else await self._watch.change()
        if how is not None:
            raise self._unconfirmed.change(how)
