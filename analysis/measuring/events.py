"""Describes the events of runs in words, and writes the events of a sweep to `events.parquet`."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]
import pyarrow.parquet as pq  # type: ignore[import-untyped]

from analysis.arrays import OUTCOMES, BoolArray
from foundry.records import RunSummary
from foundry.texts import one_line

FILE = "events.parquet"
LONGEST_TEXT = 120
"""Maximum number of characters of a quoted message, or of the cause of a failure, in an event."""


class Event(msgspec.Struct, frozen=True, array_like=True):
    """An event of a run.

    Attributes:
        step: 1-based step; 0 before the first step.
        agent: agent id; None if the event is not about a single agent.
        event: identifier of the event, such as `first_warning`.
    """

    step: int
    agent: int | None
    event: str
    text: str


def unreadable_replies(run: Any) -> Iterator[Event]:
    """Yield an event for each unreadable decision of a run (`analysis.any.any_run.AnyRun`)."""
    for place in np.flatnonzero(~run.readable).tolist():
        agent, kind, outcome = int(run.agent[place]), run.kind[place], OUTCOMES[int(run.outcome[place])]
        yield Event(int(run.step[place]), agent, "unreadable", f"agent {agent}: no readable {kind} ({outcome})")


def failure(summary: RunSummary | None, last_step: int) -> list[Event]:
    """Return an event that says why a run failed after its last step; [] without a summary of the failure."""
    if summary is None:
        return []
    cause = one_line(f"{summary.error_type}: {summary.error}", LONGEST_TEXT)
    return [Event(last_step, None, "failed", f"run failed: {cause}")]


def beginnings(flags: BoolArray) -> list[int]:
    """Return the index of the first True of each unbroken sequence of True in flags (T,)."""
    before = np.concatenate([[False], flags[:-1]]) if len(flags) else flags
    return np.flatnonzero(flags & ~before).tolist()


class EventsFile:
    """Collects the events of runs, and writes them run by run, in the order in which the runs were added."""

    def __init__(self) -> None:
        self._events: dict[tuple[str, str], list[Event]] = {}

    def add(self, sweep: str, run: str, events: Iterable[Event]) -> None:
        """Add events of a run."""
        self._events.setdefault((sweep, run), []).extend(events)

    def write(self, folder: Path) -> Path:
        """Write the file and return its path; if there are several sweeps, it has a column `sweep`."""
        several = len({sweep for sweep, _ in self._events}) > 1
        schema = SCHEMA.insert(0, pa.field("sweep", pa.string())) if several else SCHEMA
        columns: dict[str, list[Any]] = {name: [] for name in schema.names}
        for (sweep, run), events in self._events.items():
            for event in sorted(
                events, key=lambda event: (event.step, -1 if event.agent is None else event.agent, event.event)
            ):
                row = {"sweep": sweep, "run": run, **msgspec.structs.asdict(event)}
                for name, values in columns.items():
                    values.append(row[name])
        pq.write_table(pa.table(columns, schema=schema), folder / FILE, compression="zstd")
        return folder / FILE


SCHEMA = pa.schema(
    [("run", pa.string()), ("step", pa.int64()), ("agent", pa.int64()), ("event", pa.string()), ("text", pa.string())]
)
"""The columns of the file of events; if there are several sweeps, the column `sweep` comes before them."""
