"""Progress and recent speed of a sweep, from the reports of its workers."""

from collections import deque
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from statistics import fmean

from foundry.expansion import is_served, settings_key
from foundry.running.build import build
from foundry.running.lane import Tally
from foundry.storing.store import RunFolder, SweepFolder

LEAST_WINDOW = 20
"""Calls over which a speed is taken at least, because replies differ in length and calls come in bursts."""
REMEMBERED = 0.5
"""Share of the calls so far over which it is taken, where that is more."""
FINENESS = 100
"""Moments of a window that are remembered, about."""
LEAST_S = 3.0
"""Nothing is said of speed before so many seconds."""


def most_calls(runs: Iterable[RunFolder]) -> dict[int, int]:
    """Return the calls that a run of each condition makes at most; each world is built once."""
    worlds = {run.run.condition: run.config()["world"] for run in runs}
    keys = {condition: settings_key(world) for condition, world in worlds.items()}
    calls = {key: build(worlds[condition]).count_calls() for condition, key in keys.items()}
    return {condition: calls[key] for condition, key in keys.items()}


@dataclass(frozen=True)
class OpenRun:
    """A run at work.

    Attributes:
        most: calls that it makes at most.
        calls: calls so far.
        cached: those of them that the cache answered.
        fresh: whether it was not begun before this session, whose answers would be in the cache.
    """

    most: int
    calls: int
    cached: int
    fresh: bool


@dataclass
class Totals(Tally):
    """Progress of a sweep with one model.

    Attributes:
        runs: its runs.
        most: calls that they make at most.
        settled: those of them of runs that were complete before this session.
        begun: whether a worker has begun with it.
        open: its runs at work; their calls are among those of all.
    """

    runs: int = 0
    most: int = 0
    settled: int = 0
    begun: bool = False
    open: tuple[OpenRun, ...] = ()

    @property
    def ended(self) -> int:
        """Runs that are complete or failed."""
        return self.complete + self.failed

    @property
    def done(self) -> int:
        """Calls of `most` that were made, or will not be made since their run has ended."""
        return self.most if self.ended == self.runs else min(self.most, self.settled + self.calls + self.spared)

    @property
    def sent(self) -> int:
        """Calls that the cache did not answer."""
        return self.calls - self.cached

    @property
    def share(self) -> float:
        """Share of the calls of a run to come that is likely to be sent, by the runs of this session.

        The cache knows the beginning of a run or nothing of it. It answers at once, so that a run at work is beyond it.
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
        """Calls to come that the cache is not likely to answer; all of them while it has answered all."""
        unopened = self.most - self.settled - self._ended_most - sum(run.most for run in self.open)
        return sum(self._whole(run) - run.calls for run in self.open) + self.share * max(0, unopened)

    def _whole(self, run: OpenRun) -> float:
        """Return the calls that a run at work is likely to make, the more the longer it has lasted."""
        return max(self._length * run.most, (run.calls + run.most) / 2) if self._length < 1 else run.most

    @property
    def _ended_most(self) -> int:
        """Calls that the runs which ended in this session could have made."""
        return self.calls - sum(run.calls for run in self.open) + self.spared

    @property
    def _length(self) -> float:
        """Share of their possible calls that ended runs made."""
        return 1 - self.spared / self._ended_most if self._ended_most else 1.0

    def merge(self, report: Mapping[str, int]) -> None:
        """Add a worker's report."""
        self.begun = True
        for name, value in report.items():
            setattr(self, name, getattr(self, name) + value)


@dataclass
class SweepProgress:
    """Reads how far a sweep is from the reports of its workers.

    Attributes:
        before: what had ended before this session, by model.
        free: models whose calls cost nothing.
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
            most, summary = self._most[run.run.condition], run.summary()
            totals.runs += 1
            totals.most += most
            if summary is not None and summary.status == "complete":
                totals.complete += 1
                totals.settled += most

    def by_model(self) -> dict[str, Totals]:
        """Return the present totals by model."""
        now = {name: Totals(**vars(totals)) for name, totals in self.before.items()}
        for report in self.folder.progress().values():
            for name, tally in report["models"].items():
                if name in now:  # else it is a model by which another command lets the sweep grow meanwhile
                    now[name].merge(tally)
            for run, counts in report.get("counts", {}).items():
                if run in self._runs:
                    name, most = self._runs[run]
                    opened = OpenRun(most, counts["calls"], counts["cached"], run not in self._begun)
                    now[name].open = (*now[name].open, opened)
        return now

    def at_end(self) -> dict[str, Totals]:
        """Return the totals of a session that is over, from what its runs say of themselves."""
        ended = {name: Totals(runs=totals.runs, most=totals.most) for name, totals in self.before.items()}
        for run in self.folder.runs():
            summary = run.summary()
            if summary is not None:
                ended[summary.model].end(summary, self._most[run.run.condition])
        return ended


class Pace:
    """Growth rate of a count, over its later half; the time before the first growth, a load perhaps, is left out."""

    def __init__(self) -> None:
        self._moments: deque[tuple[float, int]] = deque()
        self._now = self._grown_at = 0.0
        self._count = self._burst = 0

    def note(self, count: int, now: float) -> None:
        """Take up a count at a time, seconds."""
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
        """Whether a first value exists."""
        return bool(self._moments)

    @property
    def per_s(self) -> float | None:
        """Growth a second until now; None when it is too early to say."""
        since, count = self._moments[0] if self._moments else (self._now, 0)
        return (self._count - count) / (self._now - since) if self._now - since >= LEAST_S else None

    def seconds_for(self, count: float) -> float | None:
        """Return how long so much more takes; None when it is too early to say.

        Little takes as long as as little did of late, since at the end too few runs are left to keep a server busy.
        What grows in bursts stands still in between, so that the time since the last one counts as a part of the next.
        """
        window = max(LEAST_WINDOW, count)
        begin = next((one for one in reversed(self._moments) if one[1] <= self._count - window), None)
        since, before = begin or (self._moments[0] if self._moments else (self._now, 0))
        if self._grown_at <= since:
            return None
        per_s = (self._count - before) / (self._grown_at - since)
        return max(0.0, count - min(self._burst, per_s * (self._now - self._grown_at))) / per_s


class Speed:
    """Speed of a model's answers; cached answers count only if there are no others."""

    def __init__(self) -> None:
        self._all, self._sent = Pace(), Pace()

    def note(self, totals: Totals, now: float) -> None:
        """Take up the totals at a time, seconds."""
        self._all.note(totals.calls, now)
        self._sent.note(totals.sent, now)

    @property
    def calls_per_s(self) -> float | None:
        """Calls a second; None when it is too early to say."""
        return self._pace.per_s

    def left_s(self, totals: Totals) -> float | None:
        """Return the seconds that the rest of the model's runs takes; None when it is too early to say."""
        return 0.0 if totals.done == totals.most else self._pace.seconds_for(totals.to_send)

    def seconds_for(self, calls: int, totals: Totals) -> float | None:
        """Return the seconds that runs take which make so many calls at most; None when it is too early to say."""
        return self._pace.seconds_for(calls * totals.share)

    @property
    def _pace(self) -> Pace:
        return self._sent if self._sent.begun else self._all


def left_s(speeds: Mapping[str, Speed], totals: Mapping[str, Totals], free: Collection[str]) -> dict[str, float]:
    """Return the seconds that each model takes from now on; a model of which nothing can be said yet is left out.

    A model that waits for its turn is taken to be like those before it; one whose calls cost nothing takes no time.
    """
    left: dict[str, float | None] = {}
    for name, speed in speeds.items():
        one = totals[name]
        if one.calls or one.done == one.most:
            left[name] = speed.left_s(one)
        elif name in free:
            left[name] = 0.0
        else:
            others = {other: each.seconds_for(one.most, totals[other]) for other, each in speeds.items()}
            known = {other: seconds for other, seconds in others.items() if seconds is not None}
            served = [seconds for other, seconds in known.items() if other not in free] or [*known.values()]
            left[name] = fmean(served) if served else None
    return {name: seconds for name, seconds in left.items() if seconds is not None}
