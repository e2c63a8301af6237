"""What a sweep is doing just now: its open runs, how many calls are left, what failed and why."""

from __future__ import annotations

import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from foundry.records import RunSummary
from foundry.viewer.catalog import CatalogedSweep, opened_in
from foundry.viewer.remaining import LATEST, SHARE, Begun, ModelRuns, remaining

OPEN_SHOWN, CAUSES, NAMED = 200, 50, 5
"""Open runs that are told one by one, causes of failures, and failed runs that are named for each."""
_COUNTS = ("calls", "cached", "retries", "prompt_tokens", "output_tokens")


@dataclass(frozen=True)
class _Reported:
    """What the workers report.

    Attributes:
        workers: how many there are.
        opened: the runs that are open.
        counts: their calls so far, by run.
        most: the calls that they can make, by run.
        tallies: what was counted in this session, by model.
    """

    workers: int
    opened: Sequence[str]
    counts: Mapping[str, Mapping[str, Any]]
    most: Mapping[str, int]
    tallies: Mapping[str, Counter[str]]

    def made(self, run: str) -> int:
        """Return the calls of an open run so far."""
        return self.counts.get(run, {}).get("calls") or 0


def underway(sweep: CatalogedSweep) -> dict[str, Any]:
    """Return what `docs/viewer.md` says of `sweep/<sweep>/underway`.

    Raises:
        RecordError: a run's summary cannot be read.
    """
    reports = sweep.folder.progress()
    found = _reported(sweep, reports)
    counts = sweep.look_further(set(found.opened))
    sweep.most_open = max(sweep.most_open, len(found.opened)) if found.workers else 0
    all_seen = counts.total() == len(sweep.folder.sweep.runs)
    undone = Counter(sweep.models[run] for run in sweep.waiting())
    failures = _failures(sweep)
    parts = [part for report in reports.values() for part in report.get("limits", {}).values()]
    return {
        "at": time.time(),
        "runs": len(sweep.folder.sweep.runs),
        "counts": counts,
        "workers": found.workers,
        "open": [_open_run(sweep, run, found) for run in found.opened[:OPEN_SHOWN]],
        "open_runs": len(found.opened),
        **{name: sum(tally[name] for tally in found.tallies.values()) for name in _COUNTS},
        "left": _calls_left(sweep, undone, found) if all_seen else None,
        "end": _end(sweep, undone, found) if all_seen and found.workers else None,
        "wanted": sum(part["wanted"] for part in parts),
        "allowed": sum(part["allowed"] for part in parts),
        "notes": sorted({line for report in reports.values() for line in report.get("notes", ())}),
        "failures": failures[:CAUSES],
        "causes": len(failures),
        "again": f"foundry resume {sweep.folder.path}",
    }


def _reported(sweep: CatalogedSweep, reports: Mapping[str, Any]) -> _Reported:
    tallies: dict[str, Counter[str]] = defaultdict(Counter)
    for report in reports.values():
        for model, tally in report["models"].items():
            tallies[model].update(tally)
    opened = [run for run in opened_in(reports) if sweep.holds(run)]
    return _Reported(len(reports), opened, _merged(reports, "counts"), _merged(reports, "most"), tallies)


def _merged(reports: Mapping[str, Any], key: str) -> dict[str, Any]:
    return {run: found for report in reports.values() for run, found in report.get(key, {}).items()}


def _open_run(sweep: CatalogedSweep, run: str, found: _Reported) -> dict[str, Any]:
    folder, counts = sweep.run(run), found.counts.get(run, {})
    config = folder.config()
    return {
        "run": run,
        "model": config["model"]["name"],
        "prompt": config["prompt"]["name"],
        "seed": config["seed"],
        "done": sweep.steps_done(folder),
        "planned": config["world"].get("steps"),
        "expected": found.most.get(run),
        **{name: counts.get(name) for name in _COUNTS},
    }


def _calls_left(sweep: CatalogedSweep, undone: Mapping[str, int], found: _Reported) -> float | None:
    """Return the calls that are left: of open runs up to the most they can make, of others as many as ended ones made.

    Where none of a model's runs has ended, the others make as many as its open ones can. Models of which nothing is
    known are left out; None where that are all.
    """
    left: list[float] = []
    for model, runs in undone.items():
        own = [run for run in found.opened if sweep.models[run] == model]
        known = [found.most[run] for run in own if run in found.most]
        tally = found.tallies.get(model, Counter())
        ended = tally["complete"] + tally["failed"]
        if known or ended:
            made = tally["calls"] - sum(map(found.made, own))
            each = made / ended if ended else sum(known) / len(known)
            open_ones = sum(max(0, found.most[run] - found.made(run)) for run in own if run in found.most)
            left.append(open_ones + max(0, runs - len(own)) * each)
    return sum(left) if left or not undone else None


def _end(sweep: CatalogedSweep, undone: Mapping[str, int], found: _Reported) -> dict[str, Any] | None:
    """Return in how many seconds all runs have ended; None where nothing is known.

    Models of which nothing is known are judged by the others, and named.
    """
    runs = _runs_by_model(sweep, undone, found)
    judged = [model for model, own in runs.items() if own.left and not own.known]
    begun = [run for own in runs.values() for run in own.as_ended()]
    if judged and not begun:
        return None
    left = [replace(own, ended=begun) if model in judged else own for model, own in runs.items() if own.left]
    together = [own for own in left if not own.served]
    apart = [[own] for own in left if own.served]
    seconds = remaining([together, *apart], max(sweep.most_open, found.workers))
    return {**asdict(seconds), "share": SHARE, "judged_by_others": judged}


def _runs_by_model(sweep: CatalogedSweep, undone: Mapping[str, int], found: _Reported) -> dict[str, ModelRuns]:
    begun: dict[str, list[Begun]] = defaultdict(list)
    for run in found.opened:
        if started := sweep.run(run).started_at:
            one = Begun(time.time() - started, found.made(run), found.most.get(run, 0))
            begun[sweep.models[run]].append(one)
    ended = _judged_by(sweep.latest(LATEST), found.counts.values())
    return {
        model: ModelRuns(
            ended.get(model, ()),
            begun[model],
            max(0, undone.get(model, 0) - len(begun[model])),
            model in sweep.served,
        )
        for model in sweep.model_names()
    }


def _judged_by(
    ended: Mapping[str, Sequence[RunSummary]], opened: Iterable[Mapping[str, Any]]
) -> dict[str, list[Begun]]:
    """Return the ended runs that others are judged by, by model; once calls are sent, none that the cache answered."""
    sent = [one.get("calls", 0) > one.get("cached", 0) for one in opened]
    sent += [_has_sent(one) for of in ended.values() for one in of]
    return {
        model: [Begun(one.duration_s, one.counts.calls) for one in of if _has_sent(one) or not any(sent)]
        for model, of in ended.items()
    }


def _has_sent(one: RunSummary) -> bool:
    return one.counts.calls > one.counts.cached


def _failures(sweep: CatalogedSweep) -> list[dict[str, Any]]:
    """Return the causes of failures, the most frequent first, each with some of its runs."""
    found: dict[tuple[str | None, str | None], list[str]] = defaultdict(list)
    for one in sweep.failed():
        found[one.error_type, one.error].append(one.run)
    ordered = sorted(found.items(), key=lambda item: -len(item[1]))
    return [
        {"error_type": kind, "error": error, "count": len(runs), "runs": sorted(runs)[:NAMED]}
        for (kind, error), runs in ordered
    ]
