"""Reading recorded runs, and their frames as Arrow tables and as Parquet."""

from pathlib import Path

import pandas as pd
import pyarrow as pa
import pytest

import analysis
from analysis.arrow import arrow_table
from analysis.load import _of_run, read_records, read_run
from commands import succeeds
from foundry.composing.preflight import scenario_of
from foundry.errors import InputError, RecordError
from foundry.records import Outcome
from foundry.storing.store import SweepFolder
from walkers import make_condition, rewrite_run


def test_a_sweep_loads_as_tidy_tables_of_which_every_row_tells_its_model_world_prompt_and_seed(make_sweep):
    folder = make_sweep([make_condition("a", [0, 1]), make_condition("b", [0, 1])])
    loaded = analysis.load(folder.path)
    assert list(loaded.runs.columns) == ["run", "world", "model", "prompt", "seed", "status"]
    assert loaded.runs["model"].tolist() == ["a", "a", "b", "b"]
    assert len(loaded.steps) == 4 * 6 * 25
    assert {"run", "step", "message", "neighbours", "outcome"} <= set(loaded.steps.columns)
    assert set(loaded.messages["run"]) <= set(loaded.runs["run"])
    of_run = loaded.runs.set_index("run")[["world", "model", "prompt", "seed"]]
    for table in (loaded.steps, loaded.messages, loaded.agents, loaded.calls, *loaded.fixtures.values()):
        assert table.columns[:5].tolist() == ["run", *of_run.columns]
        expected = of_run.loc[table["run"]].reset_index()
        assert table[["run", *of_run.columns]].to_numpy().tolist() == expected.to_numpy().tolist()
    assert loaded.steps.groupby("model").size().to_dict() == {"a": 300, "b": 300}
    frame = _of_run(folder.runs()[1], {"step": [1], "seed": [3]})
    assert (frame["seed"].tolist(), frame["record.seed"].tolist()) == ([1], [3]), "a record's own seed is another"


def test_fires_places_and_calls_are_tables_and_personas_are_loaded_as_they_were_drawn(tmp_path):
    asked = ("model=scripted/stay", "seed=0-1", "world.agents=8", "world.steps=1", "analyze=false", "output.dir=out")
    succeeds("-m", *asked, cwd=tmp_path)
    loaded = analysis.load(tmp_path / "out")
    assert loaded.fixtures["fires"].iloc[:2, 5:].to_numpy().tolist() == [
        ["fire1", 15, 10, 3, 15.0],
        ["fire2", -15, -10, 5, 8.0],
    ]
    assert loaded.fixtures["places"].iloc[0, 5:].tolist() == ["cafe", -15, 0, -20, -10, -5, 5, 12]
    runs = SweepFolder.open(tmp_path / "out").runs()
    for row, call in zip(loaded.calls.itertuples(), [call for run in runs for call in run.calls()], strict=True):
        assert (row.step, row.agent, row.kind, row.reply) == (call.step, call.agent, call.kind, call.text)
        assert row.prompt_text == call.messages[0]["content"] and row.asked_model == "scripted/stay"
    assert loaded.calls["latency_s"].dtype == loaded.calls["prompt_tokens"].dtype == float
    assert list(loaded.agents.columns[5:]) == ["agent", "persona.gender"]
    for run in runs:
        drawn = [persona["gender"] for persona in scenario_of(run.config()).personas(run.run.seed)]
        of_run = loaded.agents[loaded.agents["run"] == run.id]
        assert list(of_run["persona.gender"]) == drawn and {"female", "male"} == set(drawn)
    runs[0].stream_path("agents").unlink()
    with pytest.raises(RecordError, match="agents.jsonl was changed after the run"):
        analysis.load(tmp_path / "out")


def test_a_torn_last_line_of_an_unfinished_run_is_left_out(make_sweep):
    folder = make_sweep([make_condition("a", [0])])
    run = folder.runs()[0]
    rewrite_run(run, "unfinished")
    torn(run.path / "steps.jsonl")
    loaded = analysis.load(folder.path)
    assert len(loaded.steps) == 6 * 25 - 1
    assert loaded.runs["status"].tolist() == ["unfinished"]


def torn(file: Path) -> None:
    file.write_bytes(file.read_bytes()[:-10])


def broken_within(file: Path) -> None:
    file.write_bytes(b'{"step": 1\n' + file.read_bytes())


@pytest.mark.parametrize(
    ("status", "name", "damage"),
    [
        ("complete", "steps.jsonl", torn),
        ("complete", "messages.jsonl", torn),
        ("complete", "messages.jsonl", Path.unlink),
        ("failed", "steps.jsonl", torn),
        ("failed", "messages.jsonl", torn),
        ("unfinished", "steps.jsonl", broken_within),
    ],
)
def test_a_file_that_the_run_did_not_write_is_named(make_sweep, status, name, damage):
    folder = make_sweep([make_condition("a", [0])])
    run = folder.runs()[0]
    rewrite_run(run, status)
    damage(run.path / name)
    with pytest.raises(RecordError, match=name):
        analysis.load(folder.path)


def test_a_run_that_never_started_has_no_rows_and_a_folder_that_is_no_sweep_is_refused(make_sweep):
    folder = make_sweep([make_condition("a", [0])])
    for file in folder.runs()[0].path.iterdir():
        file.unlink()
    folder.runs()[0].path.rmdir()
    loaded = analysis.load(folder.path)
    assert loaded.runs["status"].tolist() == ["not started"]
    assert len(loaded.steps) == len(loaded.messages) == 0
    with pytest.raises(InputError, match="does not exist"):
        analysis.load(folder.path / "none")


def test_a_world_that_is_not_2d_is_refused_by_name(make_sweep):
    folder = make_sweep([make_condition("a", [0])])
    world = {"name": "kibo", "scene": "kibo.usd", "agents": 1, "steps": 1, "half_size": "none"}
    folder.sweep.conditions[0].config["world"] = world
    with pytest.raises(InputError, match="'kibo' does not have the settings of a 2D world"):
        read_records(folder.runs()[0], None)


def test_steps_that_do_not_follow_on_one_another_are_refused(recorded):
    written = recorded()
    records = read_records(written.folder, written.folder.summary())
    with pytest.raises(RecordError, match="one line per step and agent"):
        read_run(written.folder, type(records)(records.steps[1:], records.messages))
    with pytest.raises(RecordError, match="one line per step and agent"):
        read_run(written.folder, type(records)([], []))


def test_the_arrays_hold_what_the_lines_say(recorded):
    written = recorded()
    run = written.run
    assert run.x.shape == (26, 6)
    assert run.fires.shape == (25, 6, 2)
    row = written.walk.steps[6 * 10 + 3]
    assert (run.x[10, 3], run.y[10, 3], run.x[11, 3]) == (row.x, row.y, row.x_next)
    assert run.said[10, 3] == row.message
    assert run.neighbours[10, 3] == len(row.neighbours)
    assert run.readable[10, 3] == (row.outcome in (Outcome.CHOSEN, Outcome.REPAIRED))
    assert len(run.deliveries) == len(written.walk.messages)


def test_columns_keep_their_types_and_what_is_missing_is_null():
    frame = pd.DataFrame({"a": [1, 2], "b": [0.5, float("nan")], "c": ["x", None], "d": [["x"], []]}, index=[5, 6])
    table = arrow_table(frame)
    assert table.schema.names == ["a", "b", "c", "d"]
    assert table.to_pydict() == {"a": [1, 2], "b": [0.5, None], "c": ["x", None], "d": [["x"], []]}


def test_a_column_of_labels_and_numbers_becomes_text():
    values = ["go", 3, 0.5, None, float("nan"), {"k": [1]}, "stäy"]
    table = arrow_table(pd.DataFrame({"action": pd.Series(values, dtype=object)}))
    assert table["action"].to_pylist() == ["go", "3", "0.5", None, None, '{"k": [1]}', "stäy"]


def test_what_load_gives_goes_through_arrow_and_every_table_of_an_analysis_is_csv_and_parquet(tmp_path):
    small = ("world.agents=3", "world.steps=2", "seed=0-1", "runner.workers=1", "output.dir=sweep", "analyze=false")
    succeeds("-m", "model=scripted/random,scripted/stay", *small, cwd=tmp_path)
    loaded = analysis.load(tmp_path / "sweep")
    tables = loaded.to_arrow()
    assert list(tables) == ["runs", "steps", "agents", "messages", "fires", "places", *loaded.streams]
    assert tables["runs"].column("seed").to_pylist() == [0, 1, 0, 1]
    assert tables["steps"].num_rows == len(loaded.steps) == 4 * 3 * 2
    assert pa.types.is_list(tables["steps"].schema.field("neighbours").type)
    found = analysis.analyze(tmp_path / "sweep", plots=False)
    names = {file.stem for file in found.path.glob("*.csv")}
    assert names == {file.stem for file in found.path.glob("*.parquet")} - {"steps", "events"} and "variance" in names
    for name in names:
        once, again = pd.read_csv(found.path / f"{name}.csv"), pd.read_parquet(found.path / f"{name}.parquet")
        assert list(once.columns) == list(again.columns) and len(once) == len(again)
    assert set(found.path.glob("*.parquet")) <= set(found.written)
