"""The form of the ring: its runs as arrays, and what the viewer may add (nothing here)."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from analysis.any.any_records import AnyRecords
from analysis.any.any_records import read_records as read_lines
from analysis.arrays import OUTCOMES, READABLE, BoolArray, IntArray
from analysis.form import FormAnalysis
from foundry.records import RunSummary
from foundry.storing.store import RunFolder


@dataclass(frozen=True)
class RingRun:
    """A run on the ring; T steps, N agents."""

    id: str
    place: IntArray
    place_next: IntArray
    outcome: IntArray
    readable_only: bool = False

    @cached_property
    def readable(self) -> BoolArray:
        return np.isin(self.outcome, READABLE)

    @property
    def counted(self) -> BoolArray:
        return self.readable if self.readable_only else np.ones(self.outcome.shape, dtype=np.bool_)

    @property
    def all_readable(self) -> bool:
        return bool(self.readable.all())

    def only_readable(self) -> "RingRun":
        return replace(self, readable_only=True)


class RingRecords(AnyRecords):
    """The lines of a run on the ring."""

    def arrays(self, folder: RunFolder) -> RingRun:  # type: ignore[override]
        columns = self.columns(["agent", "place", "place_next", "outcome"])
        agents = max(columns.pop("agent")) + 1
        columns["outcome"] = [OUTCOMES.index(column) for column in columns["outcome"]]
        return RingRun(folder.id, **{name: np.array(one).reshape(-1, agents) for name, one in columns.items()})


def read(folder: RunFolder, summary: RunSummary | None) -> RingRecords:
    """Read the lines of a run."""
    any_records = read_lines(folder, summary)
    return RingRecords(any_records.declared, any_records.steps, any_records.messages, any_records.unfit)


ANALYSIS = FormAnalysis(name="ring", run=RingRun, read=read)
