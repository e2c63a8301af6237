"""The rate limits of a server: what its headers ask for, and the pause that follows."""

from __future__ import annotations

import asyncio
import math
import re
import time
from collections.abc import Awaitable, Callable, Mapping
from datetime import UTC, datetime
from typing import Any

from foundry.errors import BackendError, ServerError, TransientError
from foundry.models.transport import Origin, seconds_to_wait

KINDS = ("requests", "tokens")
SECONDS = {"h": 3600.0, "m": 60.0, "s": 1.0, "ms": 1e-3, "us": 1e-6}
DURATION = re.compile(r"(?:\d+(?:\.\d+)?(?:ms|us|h|m|s))+")
PART = re.compile(r"(\d+(?:\.\d+)?)(ms|us|h|m|s)")


class Pause:
    """Holds the calls to one server back while its rate limit is used up."""

    def __init__(
        self,
        longest_s: float,
        *,
        sleep: Callable[[float], Awaitable[Any]] = asyncio.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Set the bound.

        Args:
            longest_s: the longest pause that is kept, seconds.
            sleep: waits; tests pass one that only notes how long.
            clock: the time in seconds.
        """
        self._longest_s = longest_s
        self._sleep = sleep
        self._clock = clock
        self._until = 0.0

    def note(self, wait_s: float | None) -> None:
        """Take up that the server asked for this wait; a shorter one never ends a longer one."""
        if wait_s:
            self._until = max(self._until, self._clock() + wait_s)

    async def over(self, origin: Origin) -> None:
        """Wait until calls may be sent.

        Raises:
            ServerError: that is too far away.
        """
        while (left_s := self._until - self._clock()) > 0:
            if left_s > self._longest_s:
                raise self._too_long(origin, left_s)
            await self._sleep(left_s)

    def judged(self, error: BackendError, origin: Origin) -> BackendError:
        """Return the error, or the end of the sweep where it asks for too long a wait."""
        wait_s = error.retry_after_s if isinstance(error, TransientError) else None
        return self._too_long(origin, wait_s) if wait_s is not None and wait_s > self._longest_s else error

    def _too_long(self, origin: Origin, wait_s: float) -> ServerError:
        return ServerError(
            f"{origin}: its rate limit opens again in {wait_s:.0f} s, later than model.server.longest_pause_s "
            f"({self._longest_s:g}). Go on then with: foundry resume"
        )


def wait_asked(headers: Mapping[str, str]) -> float | None:
    """Return the seconds that a response asks to wait before the next call, or None.

    `Retry-After` (and `Retry-After-Ms`) is an order; else a count of requests or tokens that has come to
    nothing asks for the time until it is reset.
    """
    milliseconds = seconds_to_wait(headers.get("retry-after-ms"), datetime.now(UTC))
    if milliseconds is not None:
        return milliseconds / 1e3
    ordered = seconds_to_wait(headers.get("retry-after"), datetime.now(UTC))
    if ordered is not None:
        return ordered
    resets = [parse_reset(headers.get(f"x-ratelimit-reset-{kind}", "")) for kind in KINDS if _used_up(headers, kind)]
    return max((reset for reset in resets if reset is not None), default=None)


def parse_reset(text: str) -> float | None:
    """Return the seconds in a duration such as `20ms`, `1s`, `6m0s` or plain `12.5`, else None."""
    text = text.strip()
    if DURATION.fullmatch(text):
        return sum(float(number) * SECONDS[unit] for number, unit in PART.findall(text))
    try:
        seconds = float(text)
    except ValueError:
        return None
    # A point in time, as some services give it, is no duration.
    return seconds if math.isfinite(seconds) and 0 <= seconds < 1e8 else None


def _used_up(headers: Mapping[str, str], kind: str) -> bool:
    try:
        return float(headers.get(f"x-ratelimit-remaining-{kind}", "")) <= 0
    except ValueError:
        return False
