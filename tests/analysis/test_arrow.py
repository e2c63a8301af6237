"""Frames as Arrow tables and as Parquet."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pyarrow as pa
import pytest

import foundry
from analysis.arrow import arrow_table


def test_columns_keep_their_types_and_what_is_missing_is_null():
    frame = pd.DataFrame({"a": [1, 2], "b": [0.5, float("nan")], "c": ["x", None], "d": [["x"], []]}, index=[5, 6])
    table = arrow_table(frame)
    assert table.schema.names == ["a", "b", "c", "d"]
    assert table.to_pydict() == {"a": [1, 2], "b": [0.5, None], "c": ["x", None], "d": [["x"], []]}


def test_a_column_of_labels_and_numbers_becomes_text():
    values = ["go", 3, 0.5, None, float("nan"), {"k": [1]}, "stäy"]
    table = arrow_table(pd.DataFrame({"action": pd.Series(values, dtype=object)}))
    assert table["action"].to_pylist() == ["go", "3", "0.5", None, None, '{"k": [1]}', "stäy"]


@pytest.fixture(scope="module")
def played(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("played")
    small = ("world.agents=3", "world.steps=2", "seed=0-1", "runner.workers=1", f"output.dir={folder}/sweep")
    return foundry.sweep("model=scripted/random,scripted/stay", *small, f"cache.path={folder}/answers.sqlite").path


def test_what_load_gives_goes_through_arrow(played):
    loaded = foundry.load(played)
    tables = loaded.to_arrow()
    assert list(tables) == ["runs", "steps", "agents", "messages", "fires", "places", *loaded.streams]
    assert tables["runs"].column("seed").to_pylist() == [0, 1, 0, 1]
    assert tables["steps"].num_rows == len(loaded.steps) == 4 * 3 * 2
    assert pa.types.is_list(tables["steps"].schema.field("neighbours").type)


def test_every_table_of_the_analysis_is_there_as_parquet_with_the_numbers_of_its_csv(played):
    found = foundry.analyze(played, plots=False)
    names = {file.stem for file in found.path.glob("*.csv")}
    assert names == {file.stem for file in found.path.glob("*.parquet")} - {"steps", "events"} and "variance" in names
    for name in names:
        once, again = pd.read_csv(found.path / f"{name}.csv"), pd.read_parquet(found.path / f"{name}.parquet")
        assert list(once.columns) == list(again.columns) and len(once) == len(again)
    assert set(found.path.glob("*.parquet")) <= set(found.written)
