"""Runs of worlds of rounds: agents that decide at once or in turn, round by round."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from analysis.any.arrays import COMMON, objects
from analysis.any.records import AnyRecords
from analysis.any.records import read_records as read_any
from analysis.form import Figures, FormAnalysis
from analysis.lines import read_further
from analysis.rounds.run import RoundsRun
from analysis.rounds.words import WORDS
from foundry.records import Message, RunSummary
from foundry.storing.store import RECORD_STREAMS, RunFolder


@dataclass(frozen=True)
class RoundsRecords:
    """The lines of one run.

    Attributes:
        general: what every form has.
        streams: the lines of the further files that its world declares, by stream.
    """

    general: AnyRecords
    streams: Mapping[str, Sequence[Mapping[str, Any]]]

    @property
    def messages(self) -> list[Message]:
        """The deliveries."""
        return self.general.messages

    def rows(self) -> list[dict[str, Any]]:
        """Return the decisions as rows of a table."""
        return self.general.rows()

    def columns(self, names: Iterable[str]) -> dict[str, list[Any]]:
        """Return the decisions by column."""
        return self.general.columns(names)

    def decisions(self) -> dict[str, list[Any]]:
        """Return the keys that all forms have, by column."""
        return self.general.decisions()

    def arrays(self, folder: RunFolder) -> RoundsRun:
        """Return a complete run as arrays.

        Raises:
            RecordError: the lines are not what the world declares.
        """
        own = [key for key in self.general.keys if key not in COMMON]
        columns = {key: objects(values) for key, values in self.general.columns(own).items()}
        return RoundsRun.of(self.general.arrays(folder), columns=columns, streams=self.streams)


def _read(folder: RunFolder, summary: RunSummary | None) -> RoundsRecords:
    further = {name: read_further(folder, name, summary) for name in folder.streams if name not in RECORD_STREAMS}
    return RoundsRecords(read_any(folder, summary), further)


def _figures(seed: int) -> Figures:
    from analysis.rounds.figures import RoundsFigures  # what is drawn is not needed to load a sweep

    return RoundsFigures(seed)


ANALYSIS = FormAnalysis(name="rounds", run=RoundsRun, read=_read, figures=_figures, words=WORDS)
