"""The progress of a sweep, its recent speed and the time left, from the reports of its workers."""

from collections import deque
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from statistics import fmean

from foundry.expansion import is_served, settings_key
from foundry.running.build import build
from foundry.running.lane import Tally
from foundry.storing.store import RunFolder, SweepFolder

LEAST_WINDOW = 20
"""A speed is computed from at least this number of calls, because replies differ in length and come in bursts."""
REMEMBERED = 0.5
"""A speed is computed from the latest half of the calls so far, or from LEAST_WINDOW calls if these are more."""
FINENESS = 100
"""Approximate number of points in time for which a count is remembered."""
LEAST_S = 3.0
"""A speed is computed from at least this time, seconds."""


def most_calls(runs: Iterable[RunFolder]) -> dict[int, int]:
    """Return the maximum number of calls of a run, for each condition of these runs."""
    worlds = {run.run.condition: run.config()["world"] for run in runs}
    keys = {condition: settings_key(world) for condition, world in worlds.items()}
    calls = {key: build(worlds[condition]).count_calls() for condition, key in keys.items()}
    return {condition: calls[key] for condition, key in keys.items()}


@dataclass(frozen=True)
class OpenRun:
    """A run that a worker is playing.

    Attributes:
        most: maximum number of calls of the run.
        calls: number of calls so far.
        cached: number of these calls that the cache answered.
        fresh: whether it first began in this session; if not, the cache has its earlier answers.
    """

    most: int
    calls: int
    cached: int
    fresh: bool


@dataclass
class Totals(Tally):
    """The progress of one model's runs in a sweep.

    Attributes:
        runs: number of runs.
        most: maximum number of calls of all runs.
        settled: maximum number of calls of the runs that were complete before this session.
        begun: whether a worker has begun a run of the model in this session.
        open: the runs that workers are playing; the counts include their calls.
    """

    runs: int = 0
    most: int = 0
    settled: int = 0
    begun: bool = False
    open: tuple[OpenRun, ...] = ()

    @property
    def ended(self) -> int:
        """Number of runs that are complete or failed."""
        return self.complete + self.failed

    @property
    def done(self) -> int:
        """Number of calls, at most `most`, that were made or that an ended run did not need."""
        return self.most if self.ended == self.runs else min(self.most, self.settled + self.calls + self.spared)

    @property
    def sent(self) -> int:
        """Number of calls that the cache did not answer."""
        return self.calls - self.cached

    @property
    def share(self) -> float:
        """Expected share of a run's maximum number of calls that the run will really send to its server.

        It is estimated from the runs of this session. The cache can only answer the calls at the beginning of a run.
        These answers come at once, so an open run has already got them.
        """
        if not self.sent:
            return self._length
        fresh = [run for run in self.open if run.fresh]
        sent: float = self.sent - sum(run.calls - run.cached for run in self.open)
        sent += sum(self._whole(run) - run.cached for run in fresh)
        most = self._ended_most + sum(run.most for run in fresh)
        return sent / most if most else 1.0

    @property
    def to_send(self) -> float:
        """Expected number of calls that will still be sent; before the first one, no cached answers are assumed."""
        unopened = self.most - self.settled - self._ended_most - sum(run.most for run in self.open)
        return sum(self._whole(run) - run.calls for run in self.open) + self.share * max(0, unopened)

    def _whole(self, run: OpenRun) -> float:
        return max(self._length * run.most, (run.calls + run.most) / 2) if self._length < 1 else run.most

    @property
    def _ended_most(self) -> int:
        """Maximum number of calls of the runs that ended in this session."""
        return self.calls - sum(run.calls for run in self.open) + self.spared

    @property
    def _length(self) -> float:
        """The ended runs' number of calls, divided by their maximum number of calls."""
        return 1 - self.spared / self._ended_most if self._ended_most else 1.0

    def merge(self, report: Mapping[str, int]) -> None:
        """Add the counts in a worker's report to these totals."""
        self.begun = True
        for name, value in report.items():
            setattr(self, name, getattr(self, name) + value)


@dataclass
class SweepProgress:
    """Reads the progress of a sweep from the reports of its workers.

    Attributes:
        before: totals at the beginning of this session, by model.
        free: names of the models without a server, whose calls cost nothing.
    """

    folder: SweepFolder
    before: dict[str, Totals] = field(default_factory=dict)
    free: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        runs = self.folder.runs()
        self._most = most_calls(runs)
        self._begun = self.folder.begun()
        self._runs = {run.id: (str(run.config()["model"]["name"]), self._most[run.run.condition]) for run in runs}
        models = {str(run.config()["model"]["name"]): run.config()["model"] for run in runs}
        self.free = {name for name, config in models.items() if not is_served(config)}
        for run in runs:
            totals = self.before.setdefault(str(run.config()["model"]["name"]), Totals())
            most = self._most[run.run.condition]
            totals.runs += 1
            totals.most += most
            if run.is_complete:
                totals.complete += 1
                totals.settled += most

    def by_model(self) -> dict[str, Totals]:
        """Return each model's present progress: its numbers of runs, calls and tokens."""
        now = {name: Totals(**vars(totals)) for name, totals in self.before.items()}
        for report in self.folder.progress().values():
            for name, tally in report["models"].items():
                if name in now:  # else another command has just added this model to the sweep
                    now[name].merge(tally)
            for run, counts in report.get("counts", {}).items():
                if run in self._runs:
                    name, most = self._runs[run]
                    opened = OpenRun(most, counts["calls"], counts["cached"], run not in self._begun)
                    now[name].open = (*now[name].open, opened)
        return now

    def at_end(self) -> dict[str, Totals]:
        """Return the totals of each model at the end of the session, from the files `run.json` of the runs."""
        ended = {name: Totals(runs=totals.runs, most=totals.most) for name, totals in self.before.items()}
        for run in self.folder.runs():
            summary = run.summary()
            if summary is not None:
                ended[summary.model].end(summary, self._most[run.run.condition])
        return ended


class Pace:
    """The recent speed at which a count grows, such as the number of calls: over the second half of the count so far.

    The time before the first growth is left out, because a model may load then.
    """

    def __init__(self) -> None:
        self._moments: deque[tuple[float, int]] = deque()
        self._now = self._grown_at = 0.0
        self._count = self._burst = 0

    def note(self, count: int, now: float) -> None:
        """Remember that the count is `count` at the time `now`, seconds."""
        self._now = now
        if count <= self._count:
            return
        self._burst = max(self._burst, count - self._count)
        self._count, self._grown_at = count, now
        if not self._moments or count - self._moments[-1][1] >= REMEMBERED * count / FINENESS:
            self._moments.append((now, count))
        while len(self._moments) > 1 and self._moments[1][1] <= count - max(LEAST_WINDOW, REMEMBERED * count):
            self._moments.popleft()

    @property
    def begun(self) -> bool:
        """True if the count has grown at least once."""
        return bool(self._moments)

    @property
    def per_s(self) -> float | None:
        """Mean growth of the count per second; None if it is too early to tell."""
        since, count = self._moments[0] if self._moments else (self._now, 0)
        return (self._count - count) / (self._now - since) if self._now - since >= LEAST_S else None

    def seconds_for(self, count: float) -> float | None:
        """Return how many seconds it will take until the count has grown by `count`; None if it is too early to tell.

        A small growth takes as long as the latest growth of that size, since the last runs cannot keep a server busy.
        A count may grow in bursts. So the time since the last burst counts as a part of the time until the next.
        """
        window = max(LEAST_WINDOW, count)
        begin = next((moment for moment in reversed(self._moments) if moment[1] <= self._count - window), None)
        since, before = begin or (self._moments[0] if self._moments else (self._now, 0))
        if self._grown_at <= since:
            return None
        per_s = (self._count - before) / (self._grown_at - since)
        return max(0.0, count - min(self._burst, per_s * (self._now - self._grown_at))) / per_s


class Speed:
    """The speed at which a model answers. The speed includes cached answers only while no call has been sent."""

    def __init__(self) -> None:
        self._all, self._sent = Pace(), Pace()

    def note(self, totals: Totals, now: float) -> None:
        """Remember the totals of a model at the time `now`, seconds."""
        self._all.note(totals.calls, now)
        self._sent.note(totals.sent, now)

    @property
    def calls_per_s(self) -> float | None:
        """Calls per second; None if it is too early to tell."""
        return self._pace.per_s

    def left_s(self, totals: Totals) -> float | None:
        """Return the seconds until all runs of the model have ended; None if it is too early to tell."""
        return 0.0 if totals.done == totals.most else self._pace.seconds_for(totals.to_send)

    def seconds_for(self, calls: int, totals: Totals) -> float | None:
        """Return how long runs with at most `calls` calls will take, seconds; None if too few calls have been timed."""
        return self._pace.seconds_for(calls * totals.share)

    @property
    def _pace(self) -> Pace:
        return self._sent if self._sent.begun else self._all


def left_s(speeds: Mapping[str, Speed], totals: Mapping[str, Totals], free: Collection[str]) -> dict[str, float]:
    """Return for each model the seconds until all its runs have ended; leave out a model if it is too early to tell.

    A model that waits for its turn is assumed to be as fast as the models before it. Models in `free` take no time.
    """
    left: dict[str, float | None] = {}
    for name, speed in speeds.items():
        sums = totals[name]
        if sums.calls or sums.done == sums.most:
            left[name] = speed.left_s(sums)
        elif name in free:
            left[name] = 0.0
        else:
            others = {other: each.seconds_for(sums.most, totals[other]) for other, each in speeds.items()}
            known = {other: seconds for other, seconds in others.items() if seconds is not None}
            served = [seconds for other, seconds in known.items() if other not in free] or [*known.values()]
            left[name] = fmean(served) if served else None
    return {name: seconds for name, seconds in left.items() if seconds is not None}
