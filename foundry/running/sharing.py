"""Shares one limit on calls in flight among all workers that call a server.

One worker, the leader, finds the limit from the calls of all workers, and gives each worker a part of the limit. The
leader is the worker with the lowest name; if it stops reporting, the next worker leads. Workers communicate through
their progress reports, so they need a common folder.
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
"""If the report of a worker has not changed for this time, seconds, the worker counts as gone."""
PATIENCE_S = 2.0
"""Time for which a new worker waits for the reports of other workers before it finds a limit alone, seconds."""
SELDOM = 0.5
"""If calls waited for a server's limit in less than this share of the time, the server has room for more calls."""


class Part(msgspec.Struct, frozen=True):
    """A worker's report to the other workers about its calls to one server.

    Attributes:
        sums: sums over its calls so far.
        wanted: number of its calls that are in flight or wait.
        allowed: maximum number of its calls in flight.
        total: for the leader, maximum number of calls in flight of all workers; for others, the same as `allowed`.
        shares: for the leader, maximum number of calls in flight of each worker, by its name; else empty.
    """

    sums: Sums
    wanted: int
    allowed: int
    total: int
    shares: dict[str, int]


Parts = dict[str, Part]
"""Reports about calls in flight: one worker's, with servers as keys, or one server's, with workers as keys."""


class Group:
    """Searches, in the leading worker, for the best limit on calls in flight to one server, and divides the limit."""

    def __init__(self, bounds: InFlight, total: int, *, known: bool = False) -> None:
        """Begin with the limit `total`; `known` says whether an earlier search already found this limit."""
        self._climb = climb_within(bounds, total, known=known)
        self._sums = Sums()
        self._last: dict[str, Sums] = {}
        self.shares: dict[str, int] = {}

    @property
    def total(self) -> int:
        """Maximum number of all workers' calls in flight."""
        return self._climb.limit

    def take(self, parts: Mapping[str, Part]) -> None:
        """Add the calls since the last reports, and divide the server's limit among the workers.

        A worker's first report adds no calls.
        """
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
    """The limits on one worker's calls in flight, one limit per server; it may share each limit with other workers."""

    def __init__(
        self, name: str, workers: int = 1, *, apart: bool = False, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Set the worker.

        Args:
            name: name of the worker.
            workers: number of workers that begin together; each begins with an equal part of every limit.
            apart: whether workers cannot read each other's reports; then each finds its own part of the limit.
            clock: function that returns the time, seconds.
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
        """The limits on this worker's calls in flight, one per server."""
        return tuple(self._limits.values())

    @property
    def together(self) -> int:
        """Maximum number of calls in flight to the servers that this worker calls, counted over all workers."""
        return sum(self._together(key, limit) for key, limit in list(self._limits.items()))

    def _together(self, key: str, limit: Limit) -> int:
        group = self._groups.get(key)
        return self._totals.get(key, limit.allowed) if group is None else group.total

    def maker(self, model: str) -> Callable[[InFlight], Limit]:
        """Return a function that makes the limit on calls in flight for the model with the key `model`.

        For a population, the function is called once per member.
        """
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
        """Return whether a server can take more calls: since the last check, few calls waited for its limit."""
        return any([self._room_of(key, limit) for key, limit in self._limits.items()])

    def _room_of(self, key: str, limit: Limit) -> bool:
        now = limit.sums.copy()
        passed, self._seen[key] = now - self._seen.get(key, now), now
        return passed.in_flight_s > 0 and passed.waiting_s < SELDOM * passed.clock_s

    def report(self) -> Parts:
        """Return this worker's reports for the other workers, by server."""
        return {key: self._part(key) for key in self._limits}

    def exchange(self, reports: Mapping[str, Any]) -> None:
        """Update the limits from the reports of the other workers (results of `report`, decoded from JSON)."""
        others = self._alive(reports)
        for key, limit in self._limits.items():
            parts = {worker: parts_by_key[key] for worker, parts_by_key in others.items() if key in parts_by_key}
            if not parts:
                self._find_alone(key, limit)
            elif self._name < min(parts):
                self._lead(key, limit, parts)
            else:
                self._follow(key, limit, parts)

    def _alive(self, reports: Mapping[str, Any]) -> dict[str, Parts]:
        """Return the reports of the other workers, except those that have gone silent."""
        now = self._clock()
        heard = {}
        for worker, parts in _read(reports):
            before, since = self._heard.get(worker, (None, now))
            if worker != self._name:
                heard[worker] = (parts, since if parts == before else now)
        self._heard = heard
        return {worker: parts for worker, (parts, since) in heard.items() if now - since < SILENT_S}

    def _find_alone(self, key: str, limit: Limit) -> None:
        """Find the limit of a server that only this worker calls; begin at the limit that it shared before, if any."""
        group = self._groups.pop(key, None)
        known = self._totals.pop(key, None) if group is None else group.total
        if known is not None:
            limit.find(known, known=True)
        elif limit.is_shared and self._clock() - self._made[key] >= PATIENCE_S:
            limit.find(limit.bounds.initial, known=False)

    def _lead(self, key: str, limit: Limit, parts: Parts) -> None:
        if key not in self._groups:
            together = limit.allowed + sum(part.total for part in parts.values())
            known = self._totals.pop(key, None)
            self._groups[key] = Group(limit.bounds, known or together, known=known is not None)
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
    for worker, report in reports.items():
        with contextlib.suppress(msgspec.ValidationError):  # from another version of foundry
            yield worker, msgspec.convert(report, Parts)


def divided(total: int, wanted: Mapping[str, int]) -> dict[str, int]:
    """Divide a limit on calls: each worker gets as many as it wants, but at most an equal part and at least 1.

    The workers divide the remaining calls equally.

    Args:
        total: the limit.
        wanted: number of calls that each worker wants to have in flight, by its name.
    """
    shares: dict[str, int] = {}
    left = total
    for number, worker in enumerate(sorted(wanted, key=lambda worker: (wanted[worker], worker))):
        shares[worker] = max(1, min(wanted[worker], left // (len(wanted) - number)))
        left -= shares[worker]
    spare = max(0, left) // len(wanted)
    return {worker: share + spare for worker, share in shares.items()}


def _part_of(bounds: InFlight, askers: int) -> InFlight:
    least, most, initial = (max(1, bound // askers) for bound in (bounds.min, bounds.max, bounds.initial))
    return InFlight(min=least, max=most, initial=initial)
