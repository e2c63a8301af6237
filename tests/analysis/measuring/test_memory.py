"""The memory of measures saves time and decides nothing: without it the analysis is the same."""

import contextlib
import shutil
import sqlite3
from pathlib import Path

import pandas as pd
import pytest

from analysis.measuring.memory import key_of, open_memory
from analysis.measuring.runs import Source, measure_runs
from analysis.tables.signature_table import build_table
from foundry.own_code import VARIABLE
from foundry.storing.store import SweepFolder
from walkers import WORLD, make_condition, rewrite_run


@pytest.fixture
def sweep(make_sweep) -> SweepFolder:
    return make_sweep([make_condition("a", range(2), world={**WORLD, "agents": 3, "steps": 5})])


def measured(sweep: SweepFolder) -> pd.DataFrame:
    sweep.analysis_dir.mkdir(exist_ok=True)
    with open_memory(memory_of(sweep)) as memory:
        return build_table(list(measure_runs([Source(sweep, "sweep")], memory))).frame


def memory_of(sweep: SweepFolder) -> Path:
    return sweep.analysis_dir / "measured.sqlite"


def kept(sweep: SweepFolder) -> int:
    with contextlib.closing(sqlite3.connect(memory_of(sweep))) as database:
        return int(database.execute("SELECT count(*) FROM measured").fetchone()[0])


@pytest.mark.parametrize(("lock", "known"), [("EXCLUSIVE", True), ("IMMEDIATE", True), ("IMMEDIATE", False)])
def test_a_memory_that_another_process_holds_is_done_without(sweep, lock: str, known: bool):
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
def test_a_damaged_memory_is_made_anew_and_one_that_is_damaged_inside_is_done_without(sweep, damage: bytes):
    first = measured(sweep)
    memory_of(sweep).write_bytes(damage)
    pd.testing.assert_frame_equal(measured(sweep), first)
    assert kept(sweep) == 2
    with memory_of(sweep).open("r+b") as file:
        for page in range(2, memory_of(sweep).stat().st_size // 4096):
            file.seek(page * 4096)
            file.write(b"\xa5" * 4096)
    pd.testing.assert_frame_equal(measured(sweep), first)


def test_a_run_that_was_recorded_anew_is_measured_anew(sweep):
    first = measured(sweep)
    rewrite_run(sweep.runs()[0], "failed")
    again = measured(sweep)
    assert again["failure.rate"].tolist() == [1, 0] and again.loc[0].filter(like="idle_rate.").isna().all()
    pd.testing.assert_frame_equal(again[1:], first[1:])
    assert kept(sweep) == 1, "what it was before is forgotten"
    rewrite_run(sweep.runs()[0], "complete")
    pd.testing.assert_frame_equal(measured(sweep), first)


def test_a_memory_that_another_process_takes_meanwhile_is_done_without(sweep):
    first = measured(sweep)
    with (
        open_memory(memory_of(sweep)) as memory,
        contextlib.closing(sqlite3.connect(memory_of(sweep), isolation_level=None)) as holder,
    ):
        holder.execute("BEGIN EXCLUSIVE")
        again = [dict(result.measures) for result in measure_runs([Source(sweep, "sweep")], memory)]
    names = list(again[0])
    pd.testing.assert_frame_equal(pd.DataFrame(again), first[names])


def test_measures_in_a_copy_of_a_memory_are_measured_again(sweep):
    """A folder from somebody else may hold any numbers under the right keys."""
    first = measured(sweep)
    with contextlib.closing(sqlite3.connect(memory_of(sweep))) as database:
        (one,) = database.execute("SELECT measures FROM measured LIMIT 1").fetchone()
        database.execute("UPDATE measured SET measures = ?", (one,))
        database.commit()
    assert not measured(sweep).equals(first), "where they were written, they count"
    memory_of(sweep).rename(sent := sweep.path / "sent.sqlite")
    shutil.copyfile(sent, memory_of(sweep))
    pd.testing.assert_frame_equal(measured(sweep), first)
    assert kept(sweep) == 2


def test_no_two_runs_have_one_key_even_without_files_and_other_labels_and_own_code_make_others(
    make_sweep, tmp_path, monkeypatch
):
    runs = make_sweep([make_condition(model, range(2)) for model in "ab"]).runs()
    for run in runs:
        shutil.rmtree(run.path)
    keys = {key_of(run, labels) for run in runs for labels in ("rule", "judge")}
    (tmp_path / "own.py").write_text("MOST = 1\n")
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    assert len(keys | {key_of(run, "rule") for run in runs}) == 12
