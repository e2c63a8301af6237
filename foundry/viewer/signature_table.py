"""Reads the table of signatures by columns, because the whole table may be very large."""

import csv
import math
import os
from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

from foundry.texts import from_cell


class SignatureTable:
    """The table of the measures of runs, one row per run, as the latest analysis wrote it.

    Columns are read from the Parquet file. If it is missing or older than the CSV file, the whole CSV file is read.

    Args:
        file: the CSV file, with the Parquet file beside it. Both may be missing.
    """

    def __init__(self, file: Path) -> None:
        self.file = file
        self._whole: tuple[tuple[int, int], dict[str, list[str]]] = ((0, 0), {})
        self._order: tuple[tuple[int, int], dict[str, int]] = ((0, 0), {})
        self._metadata: tuple[tuple[int, int], Any] = ((0, 0), None)

    @property
    def mark(self) -> tuple[int, int]:
        """A value that changes whenever the table is written; (0, 0) if there is no table."""
        try:
            return _mark(self.file.stat())
        except FileNotFoundError:
            return 0, 0

    def names(self) -> list[str]:
        """Return the names of the columns; none if there is no table."""
        try:
            with self.file.open(encoding="utf-8", newline="") as file:
                return [from_cell(name) for name in next(csv.reader(file), [])]
        except FileNotFoundError:
            return []

    def numbers(self, name: str, runs: Sequence[str]) -> list[float | None]:
        """Return the values of the runs in a column, as numbers; None for a missing value."""
        return [_number(value) for value in self._values(name, runs)]

    def texts(self, name: str, runs: Sequence[str]) -> list[str]:
        """Return the values of the runs in a column, as texts like those in the CSV file; "" for a missing value."""
        return ["" if value is None or value != value else str(value) for value in self._values(name, runs)]

    def _values(self, name: str, runs: Sequence[str]) -> list[Any]:
        values, order = self._column(name), self._places()
        places = (order.get(run) for run in runs)
        return [None if place is None else values[place] for place in places]

    def _places(self) -> dict[str, int]:
        mark = self.mark
        if self._order[0] != mark:
            self._order = mark, {run: place for place, run in enumerate(self._column("run"))}
        return self._order[1]

    def _column(self, name: str) -> list[Any]:
        if self._is_parquet_current():
            import pyarrow.parquet as pq  # type: ignore[import-untyped] # takes longer to import than all else

            with self.file.with_suffix(".parquet").open("rb") as file:
                mark = _mark(os.fstat(file.fileno()))
                if self._metadata[0] != mark:
                    self._metadata = mark, pq.read_metadata(file)
                table = pq.ParquetFile(file, metadata=self._metadata[1]).read(columns=[name])
                column: list[Any] = table[name].to_pylist()
            return column
        return self._columns().get(name, [])

    def _is_parquet_current(self) -> bool:
        try:
            return self.file.with_suffix(".parquet").stat().st_mtime_ns >= self.mark[0]
        except FileNotFoundError:
            return False

    def _columns(self) -> dict[str, list[str]]:
        mark = self.mark
        if self._whole[0] != mark:
            with self.file.open(encoding="utf-8", newline="") as file:
                head, *rows = ([from_cell(text) for text in row] for row in csv.reader(file))
            self._whole = mark, dict(zip(head, map(list, zip_longest(*rows, fillvalue="")), strict=False))
        return self._whole[1]


def _mark(file: os.stat_result) -> tuple[int, int]:
    return file.st_mtime_ns, file.st_size


def _number(value: Any) -> float | None:
    """Return a value from the CSV or Parquet file as a finite number; None if it is not one."""
    try:
        number = float({"True": 1, "False": 0, "": None}.get(value, value))
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) else None
