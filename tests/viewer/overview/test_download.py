"""The runs and columns that are shown, as files."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from foundry.errors import InputError
from foundry.storing.store import SweepFolder
from foundry.texts import as_cell
from foundry.viewer.export import export
from foundry.viewer.resources import Resources
from foundry.viewer.server import ViewServer
from viewer_pages import go, saved

CELLS = ["=1+1", "-1.5", "-1.5 [-2, 1]", "+cmd", "@sum(a1)", "'=1", "-", "'quoted'", "1e-7", "\t=1"]


def table(made: SweepFolder, address: str) -> Any:
    return pq.read_table(io.BytesIO(Resources(made.path).get(f"sweep/made-up/parquet/{address}").content))


def test_parquet_holds_the_columns_and_runs_that_were_asked_for(made_up: SweepFolder):
    found = table(made_up, "run,idle_rate.share,seconds/oA==")  # 1010 0000
    assert found.column_names == ["run", "idle_rate.share", "seconds"]
    runs = made_up.runs()
    assert found["run"].to_pylist() == [runs[0].id, runs[2].id]
    assert found["idle_rate.share"].to_pylist() == [0.25, None]
    assert found["seconds"].to_pylist() == [1.0, 1.0]


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("run,idle_rate.shar/oA==", "Column 'idle_rate.shar' not found. Did you mean 'idle_rate.share'?"),
        ("run/oAAA", "The rows that are meant are those of 24 runs, and this sweep has 4."),
        ("run/!", "'!' does not say which rows are meant"),
    ],
)
def test_what_no_table_can_be_made_of_is_told(made_up: SweepFolder, address: str, said: str):
    with pytest.raises(InputError) as raised:
        table(made_up, address)
    assert said in str(raised.value)


@pytest.mark.browser
def test_what_is_shown_is_saved(page: Any, server: ViewServer, made_up: SweepFolder):
    go(page, server.url, "sweep/made-up?model=first&sort=-seed")
    page.wait_for_selector("[data-sort='idle_rate.share']")
    runs = made_up.runs()
    rows = list(csv.DictReader(io.StringIO(saved(page, "csv").decode())))
    assert [(row["run"], row["idle_rate.share"]) for row in rows] == [(runs[1].id, "0.001"), (runs[0].id, "0.25")]
    found = pq.read_table(io.BytesIO(saved(page, "parquet")))
    assert found["run"].to_pylist() == [runs[0].id, runs[1].id]
    assert found.column_names == list(rows[0])


@pytest.mark.browser
def test_an_export_saves_texts_of_all_kinds_as_csv(page: Any, made_up: SweepFolder, tmp_path: Path):
    exported = export(made_up.path, tmp_path / "page")
    go(page, exported.page.as_uri(), "sweep/made-up")
    page.wait_for_selector("[data-save=csv]")
    assert page.locator("[data-save=parquet]").count() == 0
    assert len(saved(page, "csv").splitlines()) == 5
    told = page.evaluate("() => Foundry.download.textOf([{key: 'a', value: (row) => row}], ['x, \"y\"\\n', null, 0.1])")
    assert list(csv.reader(io.StringIO(told, newline=""))) == [["a"], ['x, "y"\n'], [], ["0.1"]]
    told = page.evaluate("(cells) => Foundry.download.textOf([{key: 'a', value: (row) => row}], cells)", [*CELLS, -1.5])
    assert [row[0] for row in csv.reader(io.StringIO(told, newline=""))] == ["a", *map(as_cell, CELLS), "-1.5"]
    page.goto("about:blank")
