"""How sweeps look on a terminal: bars while they run, tables of plans, status, models and comparisons."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from foundry.lane import Tally
from foundry.planning import PlannedRun
from foundry.store import SweepFolder
from foundry.texts import visible

REFRESH_S = 0.25
LINE_EVERY_S = 10.0
_COUNTS = ("runs", "complete", "failed", "running", "waiting", "calls", "cached", "retries")
_NUMERIC = frozenset([*_COUNTS, "seed", "size", "context", "to send"])


@dataclass
class Totals(Tally):
    """How far a sweep is with one model, of so many runs."""

    runs: int = 0

    @property
    def ended(self) -> int:
        """Runs that are complete or failed."""
        return self.complete + self.failed

    def merge(self, report: Mapping[str, int]) -> None:
        """Add a worker's report."""
        for name, value in report.items():
            setattr(self, name, getattr(self, name) + value)


@dataclass
class SweepProgress:
    """Reads how far a sweep is from the reports of its workers.

    Attributes:
        folder: the sweep.
        before: what had ended before this session, by model.
    """

    folder: SweepFolder
    before: dict[str, Totals] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for run in self.folder.runs():
            totals = self.before.setdefault(str(run.config()["model"]["name"]), Totals())
            totals.runs += 1
            summary = run.summary()
            totals.complete += summary is not None and summary.status == "complete"

    def by_model(self) -> dict[str, Totals]:
        """Return the present totals by model."""
        now = {name: Totals(**vars(totals)) for name, totals in self.before.items()}
        for report in self.folder.progress().values():
            for name, tally in report["models"].items():
                now[name].merge(tally)
        return now

    def at_end(self) -> dict[str, Totals]:
        """Return the totals of a session that is over, from what its runs say of themselves."""
        ended = {name: Totals(runs=totals.runs) for name, totals in self.before.items()}
        for run in self.folder.runs():
            summary = run.summary()
            if summary is not None:
                ended[summary.model].end(summary)
        return ended


class ProgressDisplay:
    """Shows a sweep's progress while it runs: bars on a terminal, a line now and then elsewhere."""

    def __init__(self, folder: SweepFolder, console: Console) -> None:
        self._progress = SweepProgress(folder)
        self._console = console
        self._stop = threading.Event()
        self._started = time.monotonic()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._bars = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=24),
            MofNCompleteColumn(),
            TextColumn("{task.fields[info]}"),
            TimeElapsedColumn(),
            console=console,
            auto_refresh=False,
        )
        self._tasks: dict[str, TaskID] = {}

    def __enter__(self) -> ProgressDisplay:
        for name, totals in self._progress.before.items():
            self._tasks[name] = self._bars.add_task(visible(name), total=totals.runs, completed=totals.ended, info="")
        if self._console.is_terminal:
            self._bars.start()
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join()
        if self._console.is_terminal:
            self._bars.stop()

    def _watch(self) -> None:
        shown = time.monotonic()
        while not self._stop.wait(REFRESH_S):
            totals = self._progress.by_model()
            if self._console.is_terminal:
                self._draw(totals)
            elif time.monotonic() - shown >= LINE_EVERY_S:
                shown = time.monotonic()
                self._console.print(self._line(totals), highlight=False)
        if self._console.is_terminal:
            self._draw(self._progress.at_end())

    def _draw(self, totals: Mapping[str, Totals]) -> None:
        for name, task in self._tasks.items():
            self._bars.update(task, completed=totals[name].ended, info=self._info(name, totals[name]))
        self._bars.refresh()

    def _info(self, name: str, totals: Totals) -> str:
        elapsed = max(time.monotonic() - self._started, 1e-9)
        parts = [f"{totals.calls / elapsed:,.0f} calls/s"] if totals.calls else []
        parts += [f"{totals.cached:,} cached"] if totals.cached else []
        parts += [f"{totals.retries:,} retries"] if totals.retries else []
        parts += [f"{totals.failed} failed"] if totals.failed else []
        ended = totals.ended - self._progress.before[name].ended
        left = totals.runs - totals.ended
        parts += [f"{_duration(elapsed / ended * left)} left"] if ended and left else []
        return ", ".join(parts)

    def _line(self, totals: Mapping[str, Totals]) -> str:
        lines = [f"{name} {one.ended}/{one.runs} runs {self._info(name, one)}" for name, one in totals.items()]
        return f"[{_duration(time.monotonic() - self._started)}] " + "; ".join(line.strip() for line in lines)


def _duration(seconds: float) -> str:
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}"


def plan_table(planned: Sequence[PlannedRun], most: int = 40) -> Table:
    """Return the table of a plan; a long one is cut, its totals are not."""
    table = _table("run", "model", "prompt", "world", "seed", "calls", "cached", "to send", "state")
    for one in planned[:most]:
        cached = "?" if one.cached is None else f"{one.cached:,}"
        state = "complete" if one.complete else "to run"
        table.add_row(
            one.run.id, one.model, one.prompt, one.world, str(one.run.seed), f"{one.calls:,}", cached,
            f"{one.to_send:,}", state,
        )  # fmt: skip
    if len(planned) > most:
        table.add_row(f"and {len(planned) - most} more", *[""] * 8)
    return table


def status_table(folder: SweepFolder) -> Table:
    """Return the counts of a sweep's runs by model."""
    table = _table("model", *_COUNTS)
    opened = {run for report in folder.progress().values() for run in report["open"]}
    rows: dict[str, Counter[str]] = {}
    for run in folder.runs():
        row = rows.setdefault(str(run.config()["model"]["name"]), Counter())
        summary = run.summary()
        row["runs"] += 1
        row[summary.status if summary else "running" if run.id in opened else "waiting"] += 1
        if summary:
            counts = summary.counts
            row.update(calls=counts.calls, cached=counts.cached, retries=counts.retries)
    for model, row in rows.items():
        table.add_row(model, *(f"{row[name]:,}" for name in _COUNTS))
    return table


def failures(folder: SweepFolder, most: int = 10) -> list[str]:
    """Return one line per failed run, with its cause."""
    summaries = [summary for run in folder.runs() if (summary := run.summary())]
    failed = [f"{one.run}: {_one_line(one.error)}" for one in summaries if one.status != "complete"]
    return failed[:most] + ([f"and {len(failed) - most} more"] if len(failed) > most else [])


def _one_line(text: str | None) -> str:
    return " ".join(visible(text or "").split())


def frame_table(rows: Iterable[Sequence[str]], columns: Sequence[str]) -> Table:
    """Return a table of texts."""
    table = _table(*columns)
    for row in rows:
        table.add_row(*row)
    return table


def models_table(models: Sequence[Any]) -> Table:
    """Return the table of the models a server has."""
    table = _table("model", "digest", "size", "parameters", "quantization", "context", "capabilities", "loaded")
    for one in models:
        table.add_row(
            one.name, one.digest[:12], f"{one.size / 1e9:.1f} GB", one.parameter_size or "?",
            one.quantization or "?", f"{one.context_length:,}" if one.context_length else "?",
            ", ".join(one.capabilities), "yes" if one.loaded else "no",
        )  # fmt: skip
    return table


class _PlainTable(Table):
    """A table whose cells are text and nothing else: no markup, no commands to the terminal."""

    def add_row(self, *cells: Any, **options: Any) -> None:
        super().add_row(*(Text(visible(str(cell))) for cell in cells), **options)


def _table(*columns: str) -> Table:
    table = _PlainTable(box=None, pad_edge=False, header_style="bold")
    for column in columns:
        numeric = column in _NUMERIC
        table.add_column(column, justify="right" if numeric else "left", overflow="fold")
    return table
