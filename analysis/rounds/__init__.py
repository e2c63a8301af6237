"""Runs of worlds in rounds, where agents decide at the same time or in turn."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from analysis.any.any_arrays import COMMON, objects
from analysis.any.any_records import AnyRecords
from analysis.any.any_records import read_records as read_any
from analysis.form import Figures, FormAnalysis, Words
from analysis.labelling import Labelling
from analysis.lines import read_further
from analysis.rounds.rounds_events import events
from analysis.rounds.rounds_run import RoundsRun
from foundry.records import RunSummary
from foundry.storing.store import RECORD_STREAMS, RunFolder


def _methods(_: Sequence[Labelling]) -> list[str]:
    return ["Shares and means by round are over the agents of a run; intervals are over runs, one a seed."]


WORDS = Words(
    unread="count as the action that does nothing, where the world declares one",
    methods=_methods,
)


@dataclass(frozen=True)
class RoundsRecords(AnyRecords):
    """The recorded lines of one run, from all files that its world writes.

    Attributes:
        streams: lines of the files that only this world declares, by the file's name.
    """

    streams: Mapping[str, Sequence[Mapping[str, Any]]] = field(default_factory=dict)

    def arrays(self, folder: RunFolder) -> RoundsRun:
        """Convert the records of a complete run to arrays.

        Raises:
            RecordError: the lines do not fit the world's schema.
        """
        own = [key for key in self.keys if key not in COMMON]
        columns = {key: objects(values) for key, values in self.columns(own).items()}
        return RoundsRun.of(super().arrays(folder), columns=columns, streams=self.streams)


def _read(folder: RunFolder, summary: RunSummary | None) -> RoundsRecords:
    further = {name: read_further(folder, name, summary) for name in folder.streams if name not in RECORD_STREAMS}
    return RoundsRecords(**vars(read_any(folder, summary)), streams=further)


def _figures(seed: int) -> Figures:
    from analysis.rounds.rounds_figures import RoundsFigures  # drawing code is not needed to load a sweep

    return RoundsFigures(seed)


ANALYSIS = FormAnalysis(name="rounds", run=RoundsRun, read=_read, figures=_figures, words=WORDS, events=events)
