"""Repeats a model's calls after failures that another try may cure."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec
import numpy as np

from foundry.errors import ServerError, TransientError
from foundry.models.base import Model, Reply, Request, UnusableReply
from foundry.models.serving import Retry
from foundry.models.wrappers.wrapper import Wrapper
from foundry.records import Attempt
from foundry.texts import without_secrets

if TYPE_CHECKING:
    from tenacity import RetryCallState

T = TypeVar("T")
Sleep = Callable[[float], Awaitable[Any]]
Noted = Callable[[TransientError, float], None]
LONGEST_ASKED_S = 86_400.0
"""Longest wait that a server may request, seconds; with `longest_pause_s`, a model may allow less."""


class RetriedModel(Wrapper):
    """Repeats a call after a `TransientError`; each wait before a repeat is random and about twice as long as the last.

    The random part of a wait keeps callers that failed together from returning together. This part does not depend on a
    seed, because it affects only the time of a call, never the answer.
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
        async def attempt() -> T:
            started = time.perf_counter()
            try:
                return await call()
            except TransientError as error:
                self._noted(error, started)
                elapsed = time.perf_counter() - started
                failures.append(Attempt(error=without_secrets(str(error)), elapsed_s=elapsed, busy=error.busy))
                raise

        try:
            return await attempt()
        except TransientError as error:
            first = error
        try:
            return await self._again(attempt, first)
        except TransientError as error:
            raise _given_up(error, len(failures)) from error.__cause__

    async def _again(self, attempt: Callable[[], Awaitable[T]], first: TransientError) -> T:
        """Repeat a call as often as the settings allow; `first` is the error of its first try."""
        import tenacity  # imported here, since most calls succeed at once

        backoff = tenacity.wait_exponential(multiplier=self._retry.wait_initial_s, max=self._retry.wait_max_s)
        most = tenacity.stop_after_attempt(self._retry.attempts)
        failed, unusable = [first], 0

        async def tried() -> T:
            if failed:
                raise failed.pop()
            return await attempt()

        def is_used_up(state: RetryCallState) -> bool:
            nonlocal unusable
            unusable += isinstance(_error(state), UnusableReply)
            return unusable >= self._retry.unusable_attempts or most(state)

        def wait_s(state: RetryCallState) -> float:
            jittered = backoff(state) * float(self._jitter.uniform(0.5, 1.0))
            return max(jittered, _error(state).retry_after_s or 0.0)

        policy = tenacity.AsyncRetrying(
            retry=tenacity.retry_if_exception_type(TransientError),
            stop=is_used_up,
            wait=wait_s,
            sleep=self._sleep,
            before_sleep=_check_wait,
            reraise=True,
        )
        return await policy(tried)


def _error(state: RetryCallState) -> Any:
    return state.outcome.exception() if state.outcome else None


def _check_wait(state: RetryCallState) -> None:
    error = _error(state)
    asked_s = error.retry_after_s or 0.0
    if asked_s > LONGEST_ASKED_S:
        raise ServerError(
            f"{error} The server asks for a wait of {asked_s:.0f} s. Continue later with: foundry resume"
        ) from error


def _given_up(error: TransientError, tries: int) -> TransientError:
    if isinstance(error, UnusableReply) or tries == 1:
        return error
    cause = f"{str(error).rstrip('.')}. Given up after {tries} tries."
    return TransientError(cause, busy=error.busy, retry_after_s=error.retry_after_s)
