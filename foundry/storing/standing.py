"""How far a sweep is: counts by model, and which runs failed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

import msgspec

from foundry.records import Counts, RunSummary, reused_share
from foundry.storing.store import SweepFolder


class Standing(msgspec.Struct, kw_only=True):
    """How far a sweep is with one model; calls of running runs are those of their workers' last reports.

    Attributes:
        model: its name.
        runs: its runs, each of which is one of the next four.
        complete: that ended as they should.
        failed: that did not.
        running: that a worker has begun.
        waiting: that nobody has begun.
        calls: calls made so far, answers of the cache among them.
        cached: those that the cache answered.
        retries: tries beyond the first.
        prompt_cache: share of the prompts' tokens that servers took from their own caches; None where none said.
    """

    model: str
    runs: int = 0
    complete: int = 0
    failed: int = 0
    running: int = 0
    waiting: int = 0
    calls: int = 0
    cached: int = 0
    retries: int = 0
    prompt_cache: float | None = None


class Failure(msgspec.Struct, frozen=True):
    """A run that failed, and why."""

    run: str
    error: str | None


def standings(folder: SweepFolder, summaries: Sequence[RunSummary | None]) -> list[Standing]:
    """Return how far a sweep is with each of its models; summaries are of its runs, in their order."""
    reports = folder.progress().values()
    opened = {run for report in reports for run in report["open"]}
    so_far = {run: counts for report in reports for run, counts in report.get("counts", {}).items()}
    rows: dict[str, Counter[str]] = {}
    counted: dict[str, list[Counts]] = {}
    for run, summary in zip(folder.runs(), summaries, strict=True):
        name = str(run.config()["model"]["name"])
        row = rows.setdefault(name, Counter())
        row["runs"] += 1
        row[summary.status if summary else "running" if run.id in opened else "waiting"] += 1
        counts = summary.counts if summary else msgspec.convert(so_far.get(run.id, {}), Counts)
        row.update(calls=counts.calls, cached=counts.cached, retries=counts.retries)
        counted.setdefault(name, []).append(counts)
    return [Standing(model=name, **row, prompt_cache=reused_share(counted[name])) for name, row in rows.items()]


def failures(summaries: Iterable[RunSummary | None]) -> list[Failure]:
    """Return the runs that failed, of those that have ended."""
    return [Failure(one.run, _cause(one)) for one in summaries if one is not None and one.status != "complete"]


def _cause(summary: RunSummary) -> str | None:
    """Return what ended a run; what nobody expected has its kind in front, since its text alone may say nothing."""
    return f"{summary.error_type}: {summary.error}" if summary.traceback else summary.error
