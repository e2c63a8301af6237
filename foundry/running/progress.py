"""Progress and recent speed of a sweep, from the reports of its workers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from foundry.expansion import settings_key
from foundry.running.build import build
from foundry.running.lane import Tally
from foundry.storing.store import RunFolder, SweepFolder

SHORTEST_MEMORY_S = 60.0
"""Speed covers the last minute at least, because calls come in bursts, all agents of a step at once."""
REMEMBERED = 0.5
"""Share of the time since a model's first call that its speed is taken over, where that is longer."""
LEAST_S = 3.0
"""Nothing is said of speed before so many seconds."""


def most_calls(runs: Iterable[RunFolder]) -> dict[int, int]:
    """Return the calls that a run of each condition makes at most; each world is built once."""
    worlds = {run.run.condition: run.config()["world"] for run in runs}
    keys = {condition: settings_key(world) for condition, world in worlds.items()}
    calls = {key: build(worlds[condition]).count_calls() for condition, key in keys.items()}
    return {condition: calls[key] for condition, key in keys.items()}


@dataclass
class Totals(Tally):
    """Progress of a sweep with one model.

    Attributes:
        runs: its runs.
        most: calls that they make at most.
        settled: those of them of runs that were complete before this session.
        begun: whether a worker has begun with it.
    """

    runs: int = 0
    most: int = 0
    settled: int = 0
    begun: bool = False

    @property
    def ended(self) -> int:
        """Runs that are complete or failed."""
        return self.complete + self.failed

    @property
    def done(self) -> int:
        """Calls of `most` that were made, or will not be made since their run has ended."""
        return self.most if self.ended == self.runs else min(self.most, self.settled + self.calls + self.spared)

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
    """

    folder: SweepFolder
    before: dict[str, Totals] = field(default_factory=dict)

    def __post_init__(self) -> None:
        runs = self.folder.runs()
        self._most = most_calls(runs)
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
    """Growth rate of a count since its first growth, with more weight on recent time."""

    def __init__(self) -> None:
        self._begun: float | None = None
        self._noted_at = self._growth = self._seconds = 0.0
        self._count = 0

    def note(self, count: int, now: float) -> None:
        """Take up a count at a time, seconds; nothing begins before the first one above 0."""
        if self._begun is None:
            self._begun = now if count else None
        else:
            passed = now - self._noted_at
            weight = math.exp(-passed / max(SHORTEST_MEMORY_S, REMEMBERED * (now - self._begun)))
            self._growth = self._growth * weight + max(0, count - self._count)
            self._seconds = self._seconds * weight + passed
        self._count, self._noted_at = count, now

    @property
    def begun(self) -> bool:
        """Whether a first value exists."""
        return self._begun is not None

    @property
    def per_s(self) -> float | None:
        """Growth a second; None when it is too early to say."""
        return self._growth / self._seconds if self._seconds >= LEAST_S else None


class Speed:
    """Speed of the models' answers; cached answers count only if there are no others."""

    def __init__(self) -> None:
        self._all, self._sent = Pace(), Pace()

    def note(self, calls: int, cached: int, now: float) -> None:
        """Take up how many calls were answered, and how many of them by the cache, at a time, seconds."""
        self._all.note(calls, now)
        self._sent.note(calls - cached, now)

    @property
    def calls_per_s(self) -> float | None:
        """Calls a second; None when it is too early to say."""
        return (self._sent if self._sent.begun else self._all).per_s
