"""Sweeps of 3D worlds: reading, tables, plots; alone and beside those of 2D worlds."""

import msgspec
import pandas as pd
import pytest

import analysis
from analysis import signatures
from analysis.camera.camera_run import CameraRun
from analysis.load import read_records, read_run
from analysis.tables.texts import shown_measures
from foundry.errors import RecordError
from foundry.records import Pose
from walkers import make_condition


def test_a_sweep_loads_as_tidy_tables(camera_sweep):
    loaded = analysis.load(camera_sweep().path)
    assert loaded.runs["model"].tolist() == ["first", "first", "second", "second"]
    assert len(loaded.steps) == 4 * 20
    assert {"run", "step", "x", "yaw_next", "move_distance", "stay", "reply", "visible_px"} <= set(loaded.steps.columns)
    assert len(loaded.messages) == 0
    assert loaded.episodes["target"].tolist() == ["JAXA logo"] * 4
    assert loaded.episodes["run"].tolist() == loaded.runs["run"].tolist()


@pytest.mark.parametrize("name", ["steps.jsonl", "episode.jsonl"])
def test_a_file_that_the_run_did_not_write_or_that_is_missing_is_named(camera_sweep, name):
    folder = camera_sweep()
    file = folder.runs()[0].path / name
    file.write_bytes(file.read_bytes() + b"\n")
    with pytest.raises(RecordError, match=name):
        analysis.load(folder.path)
    file.unlink()
    with pytest.raises(RecordError, match=name):
        analysis.analyze([folder.path], plots=False)


def test_decisions_that_do_not_follow_on_one_another_are_refused(camera):
    recorded = camera(0)
    records = read_records(recorded.folder, recorded.folder.summary())
    with pytest.raises(RecordError, match="one line per decision"):
        read_run(recorded.folder, type(records)(records.episode, records.steps[1:], []))
    episode = msgspec.structs.replace(records.episode, start=Pose(9.0, 9.0, 0.0, 0.0, 0.0))
    with pytest.raises(RecordError, match="does not start at the pose where"):
        read_run(recorded.folder, type(records)(episode, records.steps, []))


def test_a_torn_last_line_of_an_unfinished_run_is_left_out(camera):
    recorded = camera(0, status="unfinished")
    file = recorded.folder.path / "steps.jsonl"
    file.write_bytes(file.read_bytes()[:-10])
    assert len(read_records(recorded.folder, None).steps) == 29
    (recorded.folder.path / "episode.jsonl").write_bytes(b'{"scene"')
    file.write_bytes(b"")
    assert read_records(recorded.folder, None).steps == []


@pytest.mark.slow
def test_the_table_and_the_plots_show_what_3d_runs_have(camera_sweep):
    folder = camera_sweep(3, run1="failed", run2="unfinished")
    found = analysis.analyze([folder.path])
    row = found.runs.iloc[0]
    run = folder.runs()[0]
    arrays = read_run(run, read_records(run, run.summary()))
    measured = signatures.measure(arrays)
    assert {name: row[name] for name in measured} == pytest.approx(measured, nan_ok=True)
    assert found.runs["failure.rate"].tolist()[:2] == [0, 1]
    assert found.runs["path_efficiency.spl"].isna().tolist()[1:3] == [True, True]
    assert found.runs["path_efficiency.spl"][0] > 0
    names = {measure.partition(".")[0] for measure in shown_measures(found.compared)}
    parts = [
        (signature.name, part)
        for signature in signatures.discover()
        for part in signature.parts
        if part.run is CameraRun
    ]
    own = {name for name, part in parts if part.applies(arrays)}
    assert own < names <= {signature.name for signature in signatures.discover() if signature.part(CameraRun)}
    assert not (found.path / "plots").exists()
    steps = pd.read_parquet(found.path / "steps.parquet")
    assert len(steps) == 4 * 20
    assert not {"reply", "notes", "image", "place"} & set(steps.columns)


@pytest.mark.slow
def test_2d_and_3d_sweeps_are_taken_together(camera_sweep, make_sweep):
    grid = make_sweep([make_condition("a", range(2))], name="grid")
    found = analysis.analyze([grid.path, camera_sweep().path], plots=False)
    assert found.runs["path_efficiency.spl"].isna().tolist() == [True] * 2 + [False] * 4
    assert found.runs["clustering.largest_group"].isna().tolist() == [False] * 2 + [True] * 4
    flat, hall = found.compared.groups[0], found.compared.groups[1]
    assert ("clustering.largest_group", hall) not in found.compared.estimates
    assert ("path_efficiency.spl", flat) not in found.compared.estimates
    assert {("idle_rate.chosen", flat), ("idle_rate.chosen", hall)} <= set(found.compared.estimates)
    steps = pd.read_parquet(found.path / "steps.parquet")
    assert steps.groupby("sweep").size().to_dict() == {"grid": 300, "hall": 80}
    assert steps.loc[steps["sweep"] == "hall", "place"].isna().all()
    assert steps.loc[steps["sweep"] == "grid", "yaw"].isna().all()
