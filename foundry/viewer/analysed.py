"""Results of a sweep's analysis for one run: its events in words, and its world's score."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from foundry.viewer.catalog import CatalogedSweep

if TYPE_CHECKING:
    import pyarrow as pa  # type: ignore[import-untyped]

_COLUMNS = ["step", "agent", "event", "text"]


class AnalysedRuns:
    """Reads the analysis results of a sweep's runs; after a new analysis it reads the events again.

    Args:
        sweep: the sweep.
    """

    def __init__(self, sweep: CatalogedSweep) -> None:
        self._sweep = sweep
        self._mark = (0, 0)
        self._events: pa.Table = None
        self._spans: dict[str, slice] = {}

    def of(self, run: str) -> dict[str, Any]:
        """Return a run's `events`, the reason `why` there are none (or ""), and its `score` or None."""
        file = self._sweep.folder.analysis_dir / "events.parquet"
        if not file.is_file():
            return {"events": [], "why": f"not analysed: foundry analyze {self._sweep.folder.path}", "score": None}
        if self._sweep.table.texts("run", [run]) != [run]:
            why = f"not in the last analysis: foundry analyze {self._sweep.folder.path}"
            return {"events": [], "why": why, "score": None}
        self._read(file)
        span = self._spans.get(run, slice(0, 0))
        columns = (self._events[name][span].to_pylist() for name in _COLUMNS)
        return {"events": list(zip(*columns, strict=True)), "why": "", "score": self._score(run)}

    def _read(self, file: Path) -> None:
        import pyarrow.parquet as pq  # type: ignore[import-untyped] # takes longer to import than all else

        found = file.stat()
        if (found.st_mtime_ns, found.st_size) == self._mark:
            return
        self._mark = found.st_mtime_ns, found.st_size
        self._events = pq.read_table(file, columns=["run", *_COLUMNS])
        self._spans = _spans(self._events["run"].combine_chunks().dictionary_encode())

    def _score(self, run: str) -> dict[str, Any] | None:
        """Return a run's score, the known values, and the mean over runs that differ only in the seed."""
        found = self._measures().get(str(self._sweep.run(run).config()["world"]["name"]))
        if found is None:
            return None
        measure, closed = found
        peers = self._sweep.seeds_of(run)
        (value,) = self._sweep.table.numbers(measure, [run])
        known = [one for one in self._sweep.table.numbers(measure, peers) if one is not None]
        if value is None:
            return None
        mean = sum(known) / len(known)
        return {"measure": measure, "value": value, "mean": mean, "runs": len(known), "known": closed}

    def _measures(self) -> dict[str, tuple[str, str]]:
        """Return, for each world with known results, the measure of these results and its closed forms in words."""
        import pyarrow.parquet as pq

        try:
            file = self._sweep.folder.analysis_dir / "validation.parquet"
            rows = pq.read_table(file, columns=["world", "measure", "closed_forms"])
        except FileNotFoundError:
            return {}
        return {row["world"]: (row["measure"], row["closed_forms"] or "") for row in rows.to_pylist()}


def _spans(runs: pa.DictionaryArray) -> dict[str, slice]:
    """Return the slice of each run's events; for a run in several sweeps, the slice of the first."""
    import numpy as np

    codes, names = runs.indices.to_numpy(), runs.dictionary.to_pylist()
    starts: Sequence[int] = np.flatnonzero(np.diff(codes, prepend=-1)).tolist()
    spans: dict[str, slice] = {}
    for start, end in zip(starts, [*starts[1:], len(codes)], strict=True):
        spans.setdefault(names[codes[start]], slice(start, end))
    return spans
