"""One limit for all workers of a server: one worker finds the limit from all workers' calls, and each takes a part.

Workers communicate through their progress reports, so sharing works wherever they have a common folder. Of the workers
that ask a server, the one with the lowest name leads; if it falls silent, the next worker leads.
"""

import contextlib
import hashlib
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import msgspec

from foundry.models.serving import InFlight
from foundry.models.wrappers.climbing import Sums
from foundry.models.wrappers.limited import Limit, climb_within

SILENT_S = 5.0
"""Seconds after which a worker with an unchanged report counts as gone."""
PATIENCE_S = 2.0
"""Seconds for which a worker waits for the first reports of the workers that begin with it."""
SELDOM = 0.5
"""Share of time in which calls waited for a limit; below it, there is room for more calls."""


class Part(msgspec.Struct, frozen=True):
    """A worker's report of its calls to one server.

    Attributes:
        sums: sums over its calls so far.
        wanted: number of its calls in flight or waiting.
        allowed: maximum number of its calls in flight.
        total: for the leader, maximum number of all workers' calls in flight; for others, their own.
        shares: for the leader, the number of allowed calls of each worker, by name.
    """

    sums: Sums
    wanted: int
    allowed: int
    total: int
    shares: dict[str, int]


Parts = dict[str, Part]
"""Parts by server, or by worker."""


class Group:
    """The leader's knowledge about one server."""

    def __init__(self, bounds: InFlight, total: int, *, found: bool = False) -> None:
        """Begin at the given limit; `found` says that an earlier climb found it."""
        self._climb = climb_within(bounds, total, found=found)
        self._sums = Sums()
        self._last: dict[str, Sums] = {}
        self.shares: dict[str, int] = {}

    @property
    def total(self) -> int:
        """Maximum number of all workers' calls in flight."""
        return self._climb.limit

    def take(self, parts: Mapping[str, Part]) -> None:
        """Add the new calls since the last report; calls before a worker's first report do not count."""
        for worker, part in parts.items():
            if worker in self._last:
                grown = part.sums - self._last[worker]
                if part.allowed > self.shares.get(worker, part.allowed):  # refused under an old limit
                    grown.refused = 0.0
                self._sums += grown
            self._last[worker] = part.sums
        self._climb.look(self._sums, len(parts))
        self.shares = divided(self.total, {worker: part.wanted for worker, part in parts.items()})


class Shared:
    """The limits of one worker; other workers may share them."""

    def __init__(
        self, name: str, workers: int = 1, *, apart: bool = False, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Set the worker.

        Args:
            name: name of the worker.
            workers: number of workers that begin together; until they know of each other, each has its part of every
                limit.
            apart: whether workers never know of each other, so that each finds a limit within its part of the bounds.
            clock: function that returns the time in seconds.
        """
        self._name = name
        self._workers = workers
        self._apart = apart
        self._clock = clock
        self._limits: dict[str, Limit] = {}
        self._made: dict[str, float] = {}
        self._groups: dict[str, Group] = {}
        self._heard: dict[str, tuple[Parts, float]] = {}
        self._seen: dict[str, Sums] = {}
        self._totals: dict[str, int] = {}

    @property
    def limits(self) -> tuple[Limit, ...]:
        """The limits of this worker."""
        return tuple(self._limits.values())

    @property
    def together(self) -> int:
        """Maximum number of calls in flight to its servers, including the calls of other workers."""
        return sum(self._together(key, limit) for key, limit in list(self._limits.items()))

    def _together(self, key: str, limit: Limit) -> int:
        group = self._groups.get(key)
        return self._totals.get(key, limit.allowed) if group is None else group.total

    def maker(self, model: str) -> Callable[[InFlight], Limit]:
        """Return a function that makes the limits of a model, given by its key, and of its member models."""
        first = len(self._limits)

        def make(bounds: InFlight) -> Limit:
            key = hashlib.blake2b(f"{len(self._limits) - first} {model}".encode(), digest_size=8).hexdigest()
            limit = self._limits[key] = Limit(_part_of(bounds, self._workers) if self._apart else bounds)
            self._made[key] = self._clock()
            if self._workers > 1 and not self._apart:
                limit.share()
                limit.allow(max(1, bounds.initial // self._workers))
            return limit

        return make

    def have_room(self) -> bool:
        """Return whether calls were made since the last question, and a limit was seldom reached."""
        return any([self._room_of(key, limit) for key, limit in self._limits.items()])

    def _room_of(self, key: str, limit: Limit) -> bool:
        now = limit.sums.copy()
        passed, self._seen[key] = now - self._seen.get(key, now), now
        return passed.in_flight_s > 0 and passed.waiting_s < SELDOM * passed.clock_s

    def report(self) -> Parts:
        """Return the facts for the other workers."""
        return {key: self._part(key) for key in self._limits}

    def exchange(self, reports: Mapping[str, Any]) -> None:
        """Read the reports of the other workers, by worker: values of `report`, decoded from JSON."""
        others = self._alive(reports)
        for key, limit in self._limits.items():
            parts = {worker: found[key] for worker, found in others.items() if key in found}
            if not parts:
                self._find_alone(key, limit)
            elif self._name < min(parts):
                self._lead(key, limit, parts)
            else:
                self._follow(key, limit, parts)

    def _alive(self, reports: Mapping[str, Any]) -> dict[str, Parts]:
        """Return the parts of the other workers with reports that still change."""
        now = self._clock()
        heard = {}
        for worker, parts in _read(reports):
            before, since = self._heard.get(worker, (None, now))
            if worker != self._name:
                heard[worker] = (parts, since if parts == before else now)
        self._heard = heard
        return {worker: parts for worker, (parts, since) in heard.items() if now - since < SILENT_S}

    def _find_alone(self, key: str, limit: Limit) -> None:
        """Find the limit alone; start from the shared limit, if there is one."""
        group = self._groups.pop(key, None)
        known = self._totals.pop(key, None) if group is None else group.total
        if known is not None:
            limit.find(known, found=True)
        elif limit.is_shared and self._clock() - self._made[key] >= PATIENCE_S:
            limit.find(limit.bounds.initial, found=False)

    def _lead(self, key: str, limit: Limit, parts: Parts) -> None:
        if key not in self._groups:
            together = limit.allowed + sum(part.total for part in parts.values())
            known = self._totals.pop(key, None)
            self._groups[key] = Group(limit.bounds, known or together, found=known is not None)
            limit.share()
        group = self._groups[key]
        group.take({**parts, self._name: self._part(key)})
        limit.allow(group.shares[self._name])

    def _follow(self, key: str, limit: Limit, parts: Parts) -> None:
        self._groups.pop(key, None)
        limit.share()
        led = parts[min(parts)]
        if not led.shares:  # it does not know of the others yet
            return
        self._totals[key] = led.total
        limit.allow(led.shares.get(self._name, max(1, led.total // (len(parts) + 1))))

    def _part(self, key: str) -> Part:
        limit, group = self._limits[key], self._groups.get(key)
        total, shares = (limit.allowed, {}) if group is None else (group.total, group.shares)
        return Part(limit.sums.copy(), limit.in_flight + limit.waiting, limit.allowed, total, shares)


def _read(reports: Mapping[str, Any]) -> Iterator[tuple[str, Parts]]:
    """Yield the readable parts of the reports, by worker."""
    for worker, report in reports.items():
        with contextlib.suppress(msgspec.ValidationError):  # from another version of foundry
            yield worker, msgspec.convert(report, Parts)


def divided(total: int, wanted: Mapping[str, int]) -> dict[str, int]:
    """Divide the total: each worker may have the calls that it wants in flight, at most an equal part; at least one."""
    shares: dict[str, int] = {}
    left = total
    for number, worker in enumerate(sorted(wanted, key=lambda worker: (wanted[worker], worker))):
        shares[worker] = max(1, min(wanted[worker], left // (len(wanted) - number)))
        left -= shares[worker]
    spare = max(0, left) // len(wanted)
    return {worker: share + spare for worker, share in shares.items()}


def _part_of(bounds: InFlight, askers: int) -> InFlight:
    """Return one worker's part of the bounds, given the number of workers."""
    least, most, initial = (max(1, bound // askers) for bound in (bounds.min, bounds.max, bounds.initial))
    return InFlight(min=least, max=most, initial=initial)
