"""The table of signatures, a column at a time, from whichever of its files is the newest."""

from __future__ import annotations

import os
from pathlib import Path

import pandas as pd
import pytest

from analysis.tables.texts import write_numbers
from foundry.viewer.signature_table import SignatureTable

RUNS = ["a", "b", "c", "d"]


@pytest.fixture
def table(tmp_path: Path) -> SignatureTable:
    """What the analysis writes of three runs."""
    frame = pd.DataFrame(
        {"run": ["c", "a", "b"], "agents": [2, 4, 2], "seen": [True, False, True], "share": [0.1, float("nan"), 1e-3]}
    )
    write_numbers(tmp_path / "signatures", frame)
    return SignatureTable(tmp_path / "signatures.csv")


def told(table: SignatureTable) -> list[object]:
    return [
        table.names(),
        table.numbers("share", RUNS),
        table.numbers("seen", RUNS),
        table.texts("agents", RUNS),
        table.texts("seen", RUNS),
        table.texts("share", RUNS),
    ]


def test_both_files_say_the_same_in_the_order_of_the_runs(table: SignatureTable):
    from_parquet = told(table)
    table.file.with_suffix(".parquet").unlink()
    assert told(table) == from_parquet
    assert from_parquet == [
        ["run", "agents", "seen", "share"],
        [None, 0.001, 0.1, None],
        [0.0, 1.0, 1.0, None],
        ["4", "2", "2", ""],
        ["False", "True", "True", ""],
        ["", "0.001", "0.1", ""],
    ]


def test_a_column_of_the_parquet_file_is_read_without_the_others(table: SignatureTable):
    head = table.file.read_bytes().splitlines()[0]
    table.file.write_bytes(head)
    os.utime(table.file, ns=(0, 0))
    assert table.numbers("share", RUNS) == [None, 0.001, 0.1, None]


def test_a_csv_file_that_was_written_later_is_read(table: SignatureTable):
    assert table.numbers("share", ["a"]) == [None]
    table.file.write_text("run,share\na,0.5\nb\n", encoding="utf-8")
    later = table.file.with_suffix(".parquet").stat().st_mtime_ns + 10**9
    os.utime(table.file, ns=(later, later))
    assert table.numbers("share", RUNS) == [0.5, None, None, None]


def test_a_table_that_is_not_there_has_no_columns(tmp_path: Path):
    table = SignatureTable(tmp_path / "signatures.csv")
    assert table.names() == [] and table.mark == (0, 0)
