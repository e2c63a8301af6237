"""The memory of measures saves time and decides nothing: without it the analysis is the same."""

from __future__ import annotations

import contextlib
import sqlite3
from pathlib import Path

import pandas as pd
import pytest

from analysis import analyze
from foundry.storing.store import SweepFolder


@pytest.fixture
def sweep(make_sweep, make_condition) -> SweepFolder:
    return make_sweep([make_condition("a", range(2))])


def measured(sweep: SweepFolder) -> pd.DataFrame:
    return analyze(sweep.path, plots=False).runs


def memory_of(sweep: SweepFolder) -> Path:
    return sweep.analysis_dir / "measured.sqlite"


def kept(sweep: SweepFolder) -> int:
    with contextlib.closing(sqlite3.connect(memory_of(sweep))) as database:
        return int(database.execute("SELECT count(*) FROM measured").fetchone()[0])


@pytest.mark.parametrize("lock", ["EXCLUSIVE", "IMMEDIATE"])
@pytest.mark.parametrize("known", [False, True])
def test_a_memory_that_another_process_holds_is_done_without(sweep: SweepFolder, lock: str, known: bool):
    first = measured(sweep)
    with contextlib.closing(sqlite3.connect(memory_of(sweep), isolation_level=None)) as holder:
        if not known:
            holder.execute("DELETE FROM measured")
        holder.execute(f"BEGIN {lock}")
        pd.testing.assert_frame_equal(measured(sweep), first)
        assert memory_of(sweep).exists(), "it belongs to the other one"
        holder.execute("ROLLBACK")
    assert kept(sweep) == (2 if known else 0)
    pd.testing.assert_frame_equal(measured(sweep), first)
    assert kept(sweep) == 2


@pytest.mark.parametrize("damage", [b"", b"no database at all " * 300])
def test_a_damaged_memory_is_made_anew(sweep: SweepFolder, damage: bytes):
    first = measured(sweep)
    memory_of(sweep).write_bytes(damage)
    pd.testing.assert_frame_equal(measured(sweep), first)
    assert kept(sweep) == 2


def test_a_memory_that_is_damaged_inside_is_done_without(sweep: SweepFolder):
    first = measured(sweep)
    with memory_of(sweep).open("r+b") as file:
        for page in range(2, memory_of(sweep).stat().st_size // 4096):
            file.seek(page * 4096)
            file.write(b"\xa5" * 4096)
    pd.testing.assert_frame_equal(measured(sweep), first)


def test_a_text_is_the_name_of_one_folder(sweep: SweepFolder):
    assert len(measured(sweep)) == len(analyze(str(sweep.path), plots=False).runs) == 2
    assert len(analyze([str(sweep.path)], plots=False).runs) == 2
