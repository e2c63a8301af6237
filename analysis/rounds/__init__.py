"""Runs of worlds of rounds: agents that decide at once or in turn, round by round."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from analysis.any.records import AnyRecords
from analysis.any.records import read_records as read_any
from analysis.form import Figures, FormAnalysis
from analysis.rounds.run import RoundsRun
from analysis.rounds.words import WORDS
from foundry.records import Message, RunSummary
from foundry.storing.store import RunFolder


@dataclass(frozen=True)
class RoundsRecords:
    """The lines of one run."""

    general: AnyRecords

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
        return RoundsRun.of(self.general.arrays(folder))


def _read(folder: RunFolder, summary: RunSummary | None) -> RoundsRecords:
    return RoundsRecords(read_any(folder, summary))


def _figures(seed: int) -> Figures:
    from analysis.rounds.figures import RoundsFigures  # what is drawn is not needed to load a sweep

    return RoundsFigures(seed)


ANALYSIS = FormAnalysis(name="rounds", run=RoundsRun, read=_read, figures=_figures, words=WORDS)
