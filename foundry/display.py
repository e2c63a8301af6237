"""Shows sweeps on a terminal: progress bars, and tables of plans, progress and models."""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import datetime
from types import TracebackType
from typing import TYPE_CHECKING, Any

from rich.cells import cell_len
from rich.table import Table
from rich.text import Text

from foundry.texts import counted, first_of, in_words, one_line, ranges, visible

if TYPE_CHECKING:
    from pathlib import Path

    from rich.console import Console, ConsoleOptions, RenderResult
    from rich.progress import TaskID

    from foundry.composing.planning import PlannedRun
    from foundry.records import Counts, RunSummary
    from foundry.running.progress import Totals
    from foundry.storing.standing import Failure, Standing
    from foundry.storing.store import SweepFolder

REFRESH_S = 0.25
LINE_EVERY_S = 10.0
_COUNTS = ("runs", "complete", "failed", "running", "waiting", "calls", "cached", "retries")
REUSED = "prompt cache"
WIDE = 120
"""A terminal with fewer characters per line is too narrow for a table with many columns of text."""
_SHORT = 12
"""Words up to this length, such as numbers, break later than longer words."""
_NUMERIC = frozenset([*_COUNTS, REUSED, "seed", "size", "context", "to send"])


class ProgressDisplay:
    """Shows the progress of a sweep: bars on a terminal, a line every ten seconds elsewhere.

    Bars count calls. The time left is for the calls whose answers are probably not in the cache.
    """

    def __init__(
        self,
        folder: SweepFolder,
        console: Console,
        *,
        each_run: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare progress bars without showing them.

        Args:
            folder: the sweep.
            console: where to print.
            each_run: whether to print a line for each run that ends.
            clock: function that returns the time, seconds.
        """
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        from foundry.running.progress import Speed, SweepProgress

        self._untold = [(run, run.summary()) for run in folder.runs() if each_run]
        self._progress = SweepProgress(folder)
        self._speeds = {name: Speed() for name in self._progress.before}
        self._console = console
        self._clock = clock
        self._stop = threading.Event()
        self._started = clock()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._bars = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=16),
            TextColumn("{task.fields[runs]}", justify="right"),
            TextColumn("{task.fields[info]}"),
            TimeElapsedColumn(),
            TextColumn("{task.fields[left]}"),
            console=console,
            auto_refresh=False,
            get_time=clock,
        )
        self._tasks = {
            name: self._bars.add_task(
                visible(name),
                total=totals.most,
                completed=totals.done,
                runs=_runs(totals),
                info="",
                left="",
                start=False,
            )
            for name, totals in self._progress.before.items()
        }
        self._whole: TaskID | None = None
        if len(self._tasks) > 1:
            before = self._progress.before.values()
            most, done = sum(totals.most for totals in before), sum(totals.done for totals in before)
            self._whole = self._bars.add_task("whole sweep", total=most, completed=done, runs="", info="", left="")

    def __enter__(self) -> ProgressDisplay:
        if self._console.is_terminal:
            self._bars.start()
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join()
        self._tell_ended()
        if self._console.is_terminal:
            self._bars.stop()

    def look(self) -> dict[str, Totals]:
        """Read the reports of the workers, update the bars, and return the totals of each model."""
        totals, now = self._progress.by_model(), self._clock()
        for name, speed in self._speeds.items():
            speed.note(totals[name], now)
        self._update(totals)
        return totals

    def left_s(self, totals: Mapping[str, Totals]) -> float | None:
        """Return the estimated seconds until the sweep ends; None if it is too early to tell."""
        left = self._left_by_model(totals)
        return sum(left.values()) if len(left) == len(totals) else None

    def _left_by_model(self, totals: Mapping[str, Totals]) -> dict[str, float]:
        from foundry.running.progress import left_s

        return left_s(self._speeds, totals, self._progress.free)

    def line(self, totals: Mapping[str, Totals]) -> str:
        """Return one line for a log, with the progress of each running model, or of all models if none is running."""
        shown = {name: sums for name, sums in totals.items() if sums.calls and sums.ended < sums.runs} or totals
        parts = [f"{visible(name)} {', '.join([_runs(sums), *self.told(name, sums)])}" for name, sums in shown.items()]
        return f"[{_duration(self._clock() - self._started)}] " + "; ".join(
            filter(None, [_left(self.left_s(totals)), *parts])
        )

    def told(self, name: str, totals: Totals) -> list[str]:
        """Return the texts beside a model's bar: its speed, and its numbers of cached, retried and failed calls."""
        parts = self._going(name, totals) if totals.ended < totals.runs else [f"{totals.calls:,} calls"]
        parts += [f"{totals.cached:,} cached"] if totals.cached else []
        parts += [f"{totals.retries:,} retries"] if totals.retries else []
        return parts + ([f"{totals.failed} failed"] if totals.failed else [])

    def _going(self, name: str, totals: Totals) -> list[str]:

        if totals.begun and not totals.calls:
            return ["no reply yet"]
        per_s = self._speeds[name].calls_per_s
        return [] if per_s is None else [_rate(per_s)]

    def _watch(self) -> None:
        shown = self._clock()
        while not self._stop.wait(REFRESH_S):
            totals = self.look()
            self._tell_ended()
            if self._console.is_terminal:
                self._bars.refresh()
            elif self._clock() - shown >= LINE_EVERY_S:
                shown = self._clock()
                self._console.print(self.line(totals), highlight=False)
        if self._console.is_terminal:
            self._update(self._progress.at_end())
            self._bars.refresh()

    def _tell_ended(self) -> None:
        """Print a line for each run that ended since the last call of this method and after this command began."""
        looked = [(run, before, run.summary() if run.ended else None) for run, before in self._untold]
        self._untold = [(run, before) for run, before, now in looked if now in (None, before)]
        for _, before, now in looked:
            if now is not None and now != before:
                self._console.print(_ended_line(now), highlight=False, markup=False)

    def _update(self, totals: Mapping[str, Totals]) -> None:
        left = self._left_by_model(totals)
        for name, task in self._tasks.items():
            sums = totals[name]
            if sums.begun:
                self._bars.start_task(task)
            info, time_left = ", ".join(self.told(name, sums)), _left(left.get(name) if sums.begun else None)
            self._bars.update(task, completed=sums.done, runs=_runs(sums), info=info, left=time_left)
            if sums.ended == sums.runs:
                self._bars.stop_task(task)
        if self._whole is not None:
            done = sum(total.done for total in totals.values())
            self._bars.update(self._whole, completed=done, left=_left(self.left_s(totals)))


def _runs(totals: Totals) -> str:
    return f"{totals.ended}/{totals.runs} run{'s' if totals.runs != 1 else ''}"


def _ended_line(ended: RunSummary) -> str:
    counts = f"{ended.counts.calls:,} calls, {ended.counts.cached:,} cached, {ended.duration_s:.1f} s"
    return f"{ended.run} {ended.status}: {counts}" + (f", {_one_line(ended.error)}" if ended.error else "")


def _left(seconds: float | None) -> str:

    return f"{_duration(seconds)} left" if seconds else ""


def _rate(per_s: float) -> str:
    if per_s >= 10:
        return f"{per_s:,.0f} calls/s"
    return f"{per_s:.1f} calls/s" if per_s >= 1 else f"{60 * per_s:.2g} calls/min"


def _duration(seconds: float) -> str:
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}"


def plan_table(planned: Sequence[PlannedRun]) -> Table:
    """Return the table of a plan, with a row for each condition; conditions with new runs come first."""
    table = _table("model", "prompt", "world", "seeds", "calls", "cached", "to send", "state")
    groups: dict[tuple[bool, int], list[PlannedRun]] = defaultdict(list)
    for planned_run in planned:
        groups[not planned_run.new, planned_run.run.condition].append(planned_run)
    for _, runs in sorted(groups.items()):
        first, complete = runs[0], sum(each.complete for each in runs)
        rest = f"{len(runs) - complete} {'new' if first.new else 'to run'}" if complete < len(runs) else ""
        state = ", ".join(filter(None, [f"{complete} complete" if complete else "", rest]))
        known = [each.cached for each in runs if each.cached is not None]
        cached = f"{sum(known):,}" if len(known) == len(runs) else "?"
        calls, to_send = sum(each.calls for each in runs), sum(each.to_send for each in runs)
        seeds = ranges([each.run.seed for each in runs])
        table.add_row(first.model, first.prompt, first.world, seeds, f"{calls:,}", cached, f"{to_send:,}", state)
    return table


def runs_table(planned: Sequence[PlannedRun]) -> Table:
    """Return the table of a plan, with a row for each run."""
    table = _table("run", "calls", "cached", "to send", "state")
    for each in planned:
        cached = "?" if each.cached is None else f"{each.cached:,}"
        state = "new" if each.new else "complete" if each.complete else "to run"
        table.add_row(each.run.id, f"{each.calls:,}", cached, f"{each.to_send:,}", state)
    return table


def status_table(standings: Sequence[Standing], width: int = WIDE) -> Table:
    """Return the table of a sweep's progress, with a row for each model.

    If servers report it, the table has the share of prompt tokens that they had in their own caches. On a narrow
    terminal, the table has no column that contains only zeros, besides runs, complete and calls.
    """
    shown = [
        name
        for name in _COUNTS
        if width >= WIDE
        or name in ("runs", "complete", "calls")
        or any(getattr(standing, name) for standing in standings)
    ]
    has_prompt_cache = any(standing.prompt_cache is not None for standing in standings)
    table = _table("model", *shown, *([REUSED] if has_prompt_cache else []))
    for standing in standings:
        share = standing.prompt_cache
        reused = ["" if share is None else f"{share:.0%}"] if has_prompt_cache else []
        table.add_row(standing.model, *(f"{getattr(standing, name):,}" for name in shown), *reused)
    return table


def ran_line(summaries: Sequence[RunSummary | None], counts: Sequence[Counts], path: Path) -> str:
    """Return a line with the number of complete runs, their folder, their time, and the calls of all begun runs.

    If the runs were interrupted, the time is left out.
    """
    ended = [summary for summary in summaries if summary is not None]
    complete = sum(summary.status == "complete" for summary in ended)
    parts = [f"{complete} of {counted(len(summaries), 'run')} complete in {path}"]
    times = [datetime.fromisoformat(at) for summary in ended for at in (summary.started, summary.ended) if at]
    span_s = (max(times) - min(times)).total_seconds() if times else 0.0
    if times and span_s <= sum(summary.duration_s for summary in ended):
        parts.append(in_words(span_s))
    retries = sum(run_counts.retries for run_counts in counts)
    calls = counted(sum(run_counts.calls for run_counts in counts), "call")
    parts.append(f"{calls} ({retries:,} retried)" if retries else calls)
    return ", ".join(parts)


def failure_lines(failed: Sequence[Failure], most: int | None = 10) -> list[str]:
    """Return a line for each cause of failure, with the runs that failed for it.

    Args:
        failed: the failed runs.
        most: maximum number of causes, and of runs that are named for a cause; None for all.
    """
    by_cause: dict[str, list[str]] = {}
    for failure in failed:
        by_cause.setdefault(_one_line(failure.error), []).append(failure.run)
    shown = list(by_cause.items())[:most]
    hidden = len(failed) - sum(len(runs) for _, runs in shown)
    lines = [f"{first_of(runs, most)}: {cause}" for cause, runs in shown]
    return lines + ([f"and {hidden} more"] if hidden else [])


def _one_line(text: str | None) -> str:
    return one_line(visible(text or ""))


def frame_table(rows: Iterable[Sequence[str]], columns: Sequence[str]) -> Table:
    """Return a table with the given column names as its heading, and the given rows."""
    table = _table(*columns)
    for row in rows:
        table.add_row(*row)
    return table


def models_table(models: Sequence[Any], width: int) -> Table:
    """Return a table of the models that a server has; with few columns if it is for a narrow terminal."""
    if width < WIDE:
        table = _table("model", "size", "weights", "context", "can", "loaded")
        for one in models:
            weights = f"{one.parameter_size or '?'} {one.quantization or '?'} {one.digest[:12]}"
            context, able = f"{one.context_length:,}" if one.context_length else "?", ", ".join(one.capabilities)
            loaded = "yes" if one.loaded else "no"
            table.add_row(one.name, f"{one.size / 1e9:.1f} GB", weights, context, able, loaded)
        return table
    table = _table("model", "digest", "size", "parameters", "quantization", "context", "capabilities", "loaded")
    for model in models:
        table.add_row(
            model.name, model.digest[:12], f"{model.size / 1e9:.1f} GB", model.parameter_size or "?",
            model.quantization or "?", f"{model.context_length:,}" if model.context_length else "?",
            ", ".join(model.capabilities), "yes" if model.loaded else "no",
        )  # fmt: skip
    return table


class _PlainTable(Table):
    """A table that shows the texts of its cells as they are; control characters are escaped.

    If the table is too wide for the terminal, its texts break at spaces. A word breaks only if nothing else is left.
    """

    def add_row(self, *cells: Any, **options: Any) -> None:
        super().add_row(*(Text(visible(str(cell))) for cell in cells), **options)

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for column, width in zip(self.columns, self._widths(options.max_width), strict=True):
            column.width = width
        yield from super().__rich_console__(console, options)

    def _widths(self, most: int) -> list[int]:
        """Return the width of each column, such that the table is at most `most` characters wide if possible."""
        texts = [[str(column.header), *map(str, column.cells)] for column in self.columns]
        widths = [max(cell_len(line) for text in column for line in text.split("\n")) for column in texts]
        longest_words = [
            max(map(cell_len, [*header.split(), *(cells if column.justify == "right" else " ".join(cells).split())]))
            for column, (header, *cells) in zip(self.columns, texts, strict=True)
        ]
        room = most - 2 * (len(widths) - 1)
        for least in (longest_words, [min(length, _SHORT) for length in longest_words], [1] * len(widths)):
            while sum(widths) > room and (
                wide := [place for place, width in enumerate(widths) if width > least[place]]
            ):
                widths[max(wide, key=widths.__getitem__)] -= 1
        return widths


def _table(*columns: str) -> Table:
    table = _PlainTable(box=None, pad_edge=False, header_style="bold")
    for column in columns:
        numeric = column in _NUMERIC
        table.add_column(column, justify="right" if numeric else "left", overflow="fold")
    return table
