"""Results of a sweep's analysis for one run: sentences about the run's events, and the score of its world."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from foundry.viewer.catalog import CatalogedSweep
from foundry.viewer.summary import label_of

if TYPE_CHECKING:
    import pyarrow as pa  # type: ignore[import-untyped]

_COLUMNS = ["step", "agent", "event", "text"]


class AnalysedRuns:
    """Reads the results of a sweep's latest analysis for single runs, and reads them again after a new analysis."""

    def __init__(self, sweep: CatalogedSweep) -> None:
        self._sweep = sweep
        self._mark = (0, 0)
        self._events: pa.Table = None
        self._spans: dict[str, slice] = {}

    def of(self, run: str) -> dict[str, Any]:
        """Return the `events` of a run, the reason `why` there are none (or ""), and its `score` (or None)."""
        file, problem = self._sweep.folder.analysis_dir / "events.parquet", ""
        if self._sweep.is_probe:
            return {"events": [], "why": "A probe has no events.", "score": None}
        if not file.is_file():
            problem = "not analysed"
        elif self._sweep.table.texts("run", [run]) != [run]:
            problem = "not in the last analysis"
        if problem:
            return {"events": [], "why": f"{problem}: foundry analyze {self._sweep.folder.path}", "score": None}
        self._read(file)
        span = self._spans.get(run, slice(0, 0))
        columns = (self._events[name][span].to_pylist() for name in _COLUMNS)
        return {"events": list(zip(*columns, strict=True)), "why": "", "score": self._score(run)}

    def _read(self, file: Path) -> None:
        import pyarrow.parquet as pq  # type: ignore[import-untyped] # takes longer to import than all else

        stat = file.stat()
        if (stat.st_mtime_ns, stat.st_size) == self._mark:
            return
        self._mark = stat.st_mtime_ns, stat.st_size
        self._events = pq.read_table(file, columns=["run", *_COLUMNS])
        self._spans = _spans(self._events["run"].combine_chunks().dictionary_encode())

    def _score(self, run: str) -> dict[str, Any] | None:
        """Return the score of a run with its measure; the mean over all seeds, and known scores in words.

        Returns None if the world of the run has no score.
        """
        import pyarrow.parquet as pq

        file = self._sweep.folder.analysis_dir / "validation.parquet"
        world = ("world", "==", str(self._sweep.run(run).config()["world"]["name"]))
        known = pq.read_table(file, filters=[world]).to_pylist() if file.exists() else []
        if not known:
            return None
        measure = known[-1]["measure"]
        (value,) = self._sweep.table.numbers(measure, [run])
        if value is None:
            return None
        values = [
            number for number in self._sweep.table.numbers(measure, self._sweep.seeds_of(run)) if number is not None
        ]
        closed_forms = known[-1]["closed_forms"] or ""
        score = {"value": value, "mean": sum(values) / len(values), "runs": len(values), "known": closed_forms}
        return {"measure": measure, "label": label_of(self._sweep.folder, measure), **score}


def _spans(runs: pa.DictionaryArray) -> dict[str, slice]:
    """Return the range of each run's rows in the table of events. If a run has several ranges, return the first."""
    import numpy as np

    codes, names = runs.indices.to_numpy(), runs.dictionary.to_pylist()
    starts: Sequence[int] = np.flatnonzero(np.diff(codes, prepend=-1)).tolist()
    spans: dict[str, slice] = {}
    for start, end in zip(starts, [*starts[1:], len(codes)], strict=True):
        spans.setdefault(names[codes[start]], slice(start, end))
    return spans
