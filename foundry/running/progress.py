"""How far a sweep is, how fast it goes of late, and how long it will take; read from the reports of its workers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from foundry.expansion import is_served, settings_key
from foundry.running.build import build
from foundry.running.lane import Tally
from foundry.storing.store import RunFolder, SweepFolder

SHORTEST_MEMORY_S = 60.0
"""Speed is that of the last minute at least: calls come in bursts, all agents of a step at once."""
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
    """How far a sweep is with one model.

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

    @property
    def left(self) -> float:
        """Calls that are left, where later runs end as early as those before them did."""
        return (self.most - self.done) * _made_share([self])

    def merge(self, report: Mapping[str, int]) -> None:
        """Add a worker's report."""
        self.begun = True
        for name, value in report.items():
            setattr(self, name, getattr(self, name) + value)


def _made_share(models: Iterable[Totals]) -> float:
    """Return the share of their possible calls that runs of these models made so far."""
    models = list(models)
    calls = sum(totals.calls for totals in models)
    return calls / (calls + sum(totals.spared for totals in models)) if calls else 1.0


@dataclass
class SweepProgress:
    """Reads how far a sweep is from the reports of its workers.

    Attributes:
        folder: the sweep.
        before: what had ended before this session, by model.
        phases: name of the phase that a model's runs are played in, by model: served models have phases of their own.
    """

    folder: SweepFolder
    before: dict[str, Totals] = field(default_factory=dict)
    phases: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        runs = self.folder.runs()
        self._most = most_calls(runs)
        for run in runs:
            model = run.config()["model"]
            name = str(model["name"])
            self.phases[name] = name if is_served(model) else ""
            totals = self.before.setdefault(name, Totals())
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
    """How fast a count grows: over all the time since its first growth, and the more the later."""

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
            kept = math.exp(-passed / max(SHORTEST_MEMORY_S, REMEMBERED * (now - self._begun)))
            self._growth = self._growth * kept + max(0, count - self._count)
            self._seconds = self._seconds * kept + passed
        self._count, self._noted_at = count, now

    @property
    def begun(self) -> bool:
        """Whether there was a first one."""
        return self._begun is not None

    @property
    def per_s(self) -> float | None:
        """Growth a second; None when it is too early to say."""
        return self._growth / self._seconds if self._seconds >= LEAST_S else None


class Speed:
    """How fast models answer; answers of the cache count only where there are no others."""

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


class TimeLeft:
    """How long a sweep takes yet, whose phases are played one after the other."""

    def __init__(self, phases: Mapping[str, str]) -> None:
        """Take the phase of each model."""
        self._phases = phases
        self._speeds = {phase: Speed() for phase in phases.values()}

    def note(self, totals: Mapping[str, Totals], now: float) -> None:
        """Take up how far the models are at a time, seconds; the speed of a phase that is over stays."""
        for phase, models in self._unfinished(totals).items():
            calls, cached = sum(model.calls for model in models), sum(model.cached for model in models)
            self._speeds[phase].note(calls, cached, now)

    def seconds(self, totals: Mapping[str, Totals]) -> float | None:
        """Return the seconds that are left, if what is left is not in the cache; None when nothing tells.

        A model that has made no call yet is taken to be as the others are on average: as slow, and its runs as short.
        """
        per_call = {phase: 1 / speed.calls_per_s for phase, speed in self._speeds.items() if speed.calls_per_s}
        unfinished = self._unfinished(totals)
        if not per_call or not unfinished:
            return None
        usual, share = sum(per_call.values()) / len(per_call), _made_share(totals.values())
        return sum(
            per_call.get(phase, usual) * model.left * (1.0 if model.calls else share)
            for phase, models in unfinished.items()
            for model in models
        )

    def _unfinished(self, totals: Mapping[str, Totals]) -> dict[str, list[Totals]]:
        """Return the models of each phase that has not ended."""
        phases: dict[str, list[Totals]] = {}
        for name, model in totals.items():
            phases.setdefault(self._phases[name], []).append(model)
        return {phase: models for phase, models in phases.items() if any(model.ended < model.runs for model in models)}
