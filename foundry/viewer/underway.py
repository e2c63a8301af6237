"""The present state of a sweep: its open runs, the number of calls to come, and the causes of failures."""

import time
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from foundry.viewer.catalog import CatalogedSweep, opened_in

OPEN_SHOWN, CAUSES, NAMED = 200, 50, 5
"""Maximum number of open runs, of causes of failures, and of failed runs per cause that the page lists."""
_COUNTS = ("calls", "cached", "retries", "prompt_tokens", "output_tokens")


@dataclass(frozen=True)
class _WorkerReports:
    """The progress of the workers, according to their reports.

    Attributes:
        workers: number of workers.
        opened: ids of the open runs.
        counts: number of calls so far and other counts, by open run.
        most: maximum number of calls, by run.
        tallies: counts since the command began, by model.
    """

    workers: int
    opened: Sequence[str]
    counts: Mapping[str, Mapping[str, Any]]
    most: Mapping[str, int]
    tallies: Mapping[str, Counter[str]]

    def made(self, run: str) -> int:
        """Return the number of calls that a run has made so far."""
        return self.counts.get(run, {}).get("calls") or 0


def underway(sweep: CatalogedSweep) -> dict[str, Any]:
    """Return the progress of a sweep, with its open runs and failures.

    `foundry/viewer/README.md` lists the keys at `sweep/<sweep>/underway`.
    """
    reports = sweep.folder.progress()
    reported = _reported(sweep, reports)
    counts = sweep.look_further(set(reported.opened))
    all_seen = counts.total() == len(sweep.folder.sweep.runs)
    left = _calls_left(sweep, reported)
    known = [calls for calls in left.values() if calls is not None]
    failures = _failures(sweep)
    parts = [part for report in reports.values() for part in report.get("limits", {}).values()]
    return {
        "at": time.time(),
        "runs": len(sweep.folder.sweep.runs),
        "counts": counts,
        "workers": reported.workers,
        "open": [_open_run(sweep, run, reported) for run in reported.opened[:OPEN_SHOWN]],
        "open_runs": len(reported.opened),
        **{name: sum(tally[name] for tally in reported.tallies.values()) for name in _COUNTS},
        "left": sum(known) if all_seen and (known or not left) else None,
        "unknown": [model for model, calls in left.items() if calls is None],
        "wanted": sum(part["wanted"] for part in parts),
        "allowed": sum(part["allowed"] for part in parts),
        "notes": sorted({line for report in reports.values() for line in report.get("notes", ())}),
        "failures": failures[:CAUSES],
        "causes": len(failures),
        "again": f"foundry resume {sweep.folder.path}",
    }


def _reported(sweep: CatalogedSweep, reports: Mapping[str, Any]) -> _WorkerReports:
    tallies: dict[str, Counter[str]] = defaultdict(Counter)
    for report in reports.values():
        for model, tally in report["models"].items():
            tallies[model].update(tally)
    opened = [run for run in opened_in(reports) if sweep.holds(run)]
    return _WorkerReports(len(reports), opened, _merged(reports, "counts"), _merged(reports, "most"), tallies)


def _merged(reports: Mapping[str, Any], key: str) -> dict[str, Any]:
    return {run: state for report in reports.values() for run, state in report.get(key, {}).items()}


def _open_run(sweep: CatalogedSweep, run: str, report: _WorkerReports) -> dict[str, Any]:
    folder, counts = sweep.run(run), report.counts.get(run, {})
    config = folder.config()
    return {
        "run": run,
        "model": config["model"]["name"],
        "prompt": config["prompt"]["name"],
        "seed": config["seed"],
        "done": sweep.steps_done(folder),
        "planned": config["world"].get("steps"),
        "expected": report.most.get(run),
        **{name: counts.get(name) for name in _COUNTS},
    }


def _calls_left(sweep: CatalogedSweep, report: _WorkerReports) -> dict[str, float | None]:
    """Estimate, for each model with unfinished runs, how many calls are still to be made; None if nothing is known.

    Each open run is taken to make its maximum number of calls. Each waiting run is taken to make as many calls as the
    ended runs of its model on average; if none has ended, as many as its open runs.
    """
    left: dict[str, float | None] = {}
    for model, runs in Counter(sweep.models[run] for run in sweep.waiting()).items():
        own = [run for run in report.opened if sweep.models[run] == model]
        known = [report.most[run] for run in own if run in report.most]
        tally = report.tallies.get(model, Counter())
        ended = tally["complete"] + tally["failed"]
        if not known and not ended:
            left[model] = None
            continue
        made = tally["calls"] - sum(map(report.made, own))
        each = made / ended if ended else sum(known) / len(known)
        open_ones = sum(max(0, report.most[run] - report.made(run)) for run in own if run in report.most)
        left[model] = open_ones + max(0, runs - len(own)) * each
    return left


def _failures(sweep: CatalogedSweep) -> list[dict[str, Any]]:
    """Return the causes of failures with some runs for each; the most frequent cause comes first."""
    runs_by_cause: dict[tuple[str | None, str | None], list[str]] = defaultdict(list)
    for summary in sweep.failed():
        runs_by_cause[summary.error_type, summary.error].append(summary.run)
    ordered = sorted(runs_by_cause.items(), key=lambda item: -len(item[1]))
    return [
        {"error_type": kind, "error": error, "count": len(runs), "runs": sorted(runs)[:NAMED]}
        for (kind, error), runs in ordered
    ]
