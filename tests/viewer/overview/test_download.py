"""The runs and columns that are shown, as files."""

import csv
import io
from pathlib import Path
from typing import Any

import pytest

from foundry.errors import InputError
from foundry.storing.store import SweepFolder
from foundry.texts import as_cell
from foundry.viewer.catalog import Catalog
from foundry.viewer.export import export
from viewer_pages import go, saved

CELLS = ["=1+1", "-1.5", "-1.5 [-2, 1]", "+cmd", "@sum(a1)", "'=1", "-", "'quoted'", "1e-7", "\t=1"]


@pytest.mark.parametrize(
    ("mask", "said"),
    [("oAAA", "The page chose among 24 runs, but the sweep has 4 runs."), ("!", "'!' is not a valid choice of runs")],
)
def test_a_mask_of_other_runs_is_refused(made_up: SweepFolder, mask: str, said: str):
    (sweep,) = Catalog(made_up.path).sweeps()
    assert sweep.runs_of_mask("oA==") == [made_up.runs()[0].id, made_up.runs()[2].id]
    with pytest.raises(InputError) as raised:
        sweep.runs_of_mask(mask)
    assert said in str(raised.value)


@pytest.mark.browser
def test_an_export_saves_texts_of_all_kinds_as_csv(page: Any, made_up: SweepFolder, tmp_path: Path):
    exported = export(made_up.path, tmp_path / "page")
    go(page, exported.page.as_uri(), "sweep/made-up")
    page.wait_for_selector("[data-save=csv]")
    assert len(saved(page, "csv").splitlines()) == 5
    told = page.evaluate("() => Foundry.download.textOf([{key: 'a', value: (row) => row}], ['x, \"y\"\\n', null, 0.1])")
    assert list(csv.reader(io.StringIO(told, newline=""))) == [["a"], ['x, "y"\n'], [], ["0.1"]]
    told = page.evaluate("(cells) => Foundry.download.textOf([{key: 'a', value: (row) => row}], cells)", [*CELLS, -1.5])
    assert [row[0] for row in csv.reader(io.StringIO(told, newline=""))] == ["a", *map(as_cell, CELLS), "-1.5"]
    page.goto("about:blank")
