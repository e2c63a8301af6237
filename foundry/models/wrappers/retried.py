"""Repeats a model's calls after failures that another try may cure."""

import asyncio
import time
from collections.abc import Awaitable, Callable
from typing import Any, TypeVar

import msgspec
import numpy as np

from foundry.errors import ServerError, TransientError
from foundry.models.base import Model, Reply, Request, UnusableReply
from foundry.models.serving import Retry
from foundry.models.wrappers.wrapper import Wrapper
from foundry.records import Attempt
from foundry.texts import without_secrets

T = TypeVar("T")
Sleep = Callable[[float], Awaitable[Any]]
Noted = Callable[[TransientError, float], None]
LONGEST_ASKED_S = 86_400.0
"""Longest wait that a server may request, seconds; a backend may allow less, such as `longest_pause_s`."""


class RetriedModel(Wrapper):
    """Repeats a call after a `TransientError`, with jittered, doubling waits.

    The random part of a wait keeps callers that failed together from returning together. No seed draws it, because it
    affects only the time of a call, never its answer.
    """

    def __init__(
        self, inner: Model, retry: Retry, *, sleep: Sleep = asyncio.sleep, noted: Noted = lambda *_: None
    ) -> None:
        """Wrap a model.

        Args:
            inner: wrapped model.
            retry: number of tries, and the waits between them. With the same seed the same answer is likely, so
                repeating a call after an unusable reply seldom helps.
            sleep: function that waits; a test may pass one that only records the time.
            noted: function that is called with the error of each failed try and its start (`time.perf_counter`).
        """
        super().__init__(inner)
        self._noted = noted
        self._retry = retry
        self._sleep = sleep
        self._jitter = np.random.default_rng()

    async def ask(self, request: Request) -> Reply:
        """Answer one request; the reply records the failed tries.

        After the last try, an unusable reply becomes the answer, and any other failure is raised.
        """
        failures: list[Attempt] = []
        try:
            reply = await self._tried(lambda: self.inner.ask(request), failures)
        except UnusableReply as error:
            reply = error.reply
        return msgspec.structs.replace(reply, attempts=tuple(failures)) if failures else reply

    async def confirm(self) -> None:
        """Let the wrapped model check its server; repeat this after failures that another try may cure."""
        await self._tried(self.inner.confirm, [])

    async def warm_up(self) -> None:
        """Load the wrapped model; repeat this after failures that another try may cure."""
        await self._tried(self.inner.warm_up, [])

    async def _tried(self, call: Callable[[], Awaitable[T]], failures: list[Attempt]) -> T:
        unusable = 0
        while True:
            started = time.perf_counter()
            try:
                return await call()
            except TransientError as error:
                self._noted(error, started)
                elapsed = time.perf_counter() - started
                failures.append(Attempt(error=without_secrets(str(error)), elapsed_s=elapsed, busy=error.busy))
                unusable += isinstance(error, UnusableReply)
                if len(failures) >= self._retry.attempts or unusable >= self._retry.unusable_attempts:
                    raise _given_up(error, len(failures)) from error.__cause__
                wait_s = self._wait_s(error, len(failures))
            await self._sleep(wait_s)

    def _wait_s(self, error: TransientError, failures: int) -> float:
        """Return the wait after a failure, seconds: at least half of the longest wait, and what the server requests."""
        asked_s = error.retry_after_s or 0.0
        if asked_s > LONGEST_ASKED_S:
            raise ServerError(
                f"{error} It asks to wait {asked_s:.0f} s. Continue later with: foundry resume"
            ) from error
        longest_s = min(self._retry.wait_max_s, self._retry.wait_initial_s * 2.0 ** min(failures - 1, 99))
        return max(longest_s * float(self._jitter.uniform(0.5, 1.0)), asked_s)


def _given_up(error: TransientError, tries: int) -> TransientError:
    if isinstance(error, UnusableReply) or tries == 1:
        return error
    cause = f"{str(error).rstrip('.')}. Given up after {tries} tries."
    return TransientError(cause, busy=error.busy, retry_after_s=error.retry_after_s)
