"""Reads how long a server wants clients to wait, and delays the calls to it."""

import asyncio
import logging
import math
import re
import time
from collections.abc import Awaitable, Callable, Mapping
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from typing import Any

from foundry.errors import BackendError, ServerError, TransientError
from foundry.models.http.transport import Origin

SAID_FROM_S = 30.0
"""Pauses from this length on are reported to the user, since nothing happens meanwhile, seconds."""
LONGEST_RESET_S = 1e8
"""A duration of this length or more, seconds, is ignored, since some services send a point in time instead."""
ORDERS = {"retry-after-ms": 1e-3, "retry-after": 1.0}
"""Headers with a time to wait, each with the length of its unit in seconds."""
BUDGETS = tuple((f"x-ratelimit-remaining-{kind}", f"x-ratelimit-reset-{kind}") for kind in ("requests", "tokens"))
"""Pairs of headers: one says how many requests or tokens are left, one when the full number is allowed again."""
SECONDS = {"h": 3600.0, "m": 60.0, "s": 1.0, "ms": 1e-3, "us": 1e-6}
DURATION = re.compile(r"(?:\d+(?:\.\d+)?(?:ms|us|h|m|s))+")
PART = re.compile(r"(\d+(?:\.\d+)?)(ms|us|h|m|s)")


class Pause:
    """Delays the calls to a server for as long as the server requests."""

    def __init__(
        self,
        longest_s: float,
        *,
        sleep: Callable[[float], Awaitable[Any]] = asyncio.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._longest_s = longest_s
        self._sleep = sleep
        self._clock = clock
        self._until = 0.0

    def note(self, wait_s: float | None, origin: Origin) -> None:
        """Record the wait that the server requests; if an earlier request asked for a later end, that end stays."""
        if not wait_s:
            return
        now = self._clock()
        if self._until <= now and SAID_FROM_S <= wait_s <= self._longest_s:
            logging.getLogger("foundry").warning("%s asks for a pause of %.0f s; calls to it wait.", origin, wait_s)
        self._until = max(self._until, now + wait_s)

    async def over(self, origin: Origin) -> None:
        """Wait until the server may be called again."""
        while (left_s := self._until - self._clock()) > 0:
            if left_s > self._longest_s:
                raise self._too_long(origin, left_s)
            await self._sleep(left_s)

    def judged(self, error: BackendError, origin: Origin) -> BackendError:
        """Return this error, or an error that ends the sweep if the server asks clients to wait too long."""
        wait_s = error.retry_after_s if isinstance(error, TransientError) else None
        return self._too_long(origin, wait_s) if wait_s is not None and wait_s > self._longest_s else error

    def _too_long(self, origin: Origin, wait_s: float) -> ServerError:
        return ServerError(
            f"{origin} asks for a pause of {wait_s:.0f} s, longer than model.server.longest_pause_s "
            f"({self._longest_s:g}). Continue later with: foundry resume"
        )


def requested_wait(headers: Mapping[str, str]) -> float | None:
    """Return how many seconds a response asks clients to wait before the next call; None if no wait is asked.

    The wait in the header `Retry-After` or `Retry-After-Ms` counts, if the response has one of them. Otherwise, if no
    requests or tokens are left, clients must wait until the server resets their budget.
    """
    for name, unit_s in ORDERS.items():
        ordered = seconds_to_wait(headers.get(name), datetime.now(UTC)) if name in headers else None
        if ordered is not None:
            return ordered * unit_s
    resets = [parse_reset(headers.get(reset, "")) for left, reset in BUDGETS if _used_up(headers.get(left))]
    return max((reset for reset in resets if reset is not None), default=None)


def parse_reset(text: str) -> float | None:
    """Return the seconds in a duration such as `20ms`, `1s`, `6m0s` or `12.5`; None for any other text."""
    text = text.strip()
    try:
        seconds = _duration(text) if DURATION.fullmatch(text) else float(text)
    except ValueError:
        return None
    return seconds if 0 <= seconds < LONGEST_RESET_S else None


def _duration(text: str) -> float:
    return sum(float(number) * SECONDS[unit] for number, unit in PART.findall(text))


def _used_up(left: str | None) -> bool:
    try:
        return left is not None and float(left) <= 0
    except ValueError:
        return False


def seconds_to_wait(retry_after: str | None, now: datetime) -> float | None:
    """Return the seconds that a `Retry-After` header gives as a number or a date; None for any other text."""
    if retry_after is None:
        return None
    try:
        seconds = float(retry_after)
    except ValueError:
        return _seconds_until(retry_after, now)
    return seconds if math.isfinite(seconds) and seconds >= 0 else None


def _seconds_until(date: str, now: datetime) -> float | None:
    try:
        moment = parsedate_to_datetime(date)
    except (ValueError, OverflowError):
        return None
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=UTC)
    return max(0.0, (moment - now).total_seconds())
