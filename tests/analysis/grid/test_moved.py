"""Runs of a world that draws its positions for each seed, and runs that nobody tells of fires."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from analysis import analyze
from analysis.load import load, read_records, read_run
from commands import statuses
from foundry.cli import run
from foundry.replay.recording import read_recording, redrawing_of
from foundry.storing.store import RunFolder, SweepFolder
from foundry.viewer.resources import open_view


def recorded_positions(folder: RunFolder) -> dict[tuple[str, str], tuple[int, int]]:
    lines = map(json.loads, (folder.path / "fixtures.jsonl").read_text(encoding="utf-8").splitlines())
    return {(line["kind"], line["name"]): (line["x"], line["y"]) for line in lines}


def shown_positions(about: Mapping[str, Any]) -> dict[tuple[str, str], tuple[int, int]]:
    keys = (("places", "center"), ("fires", "position"))
    return {(kind, thing["name"]): tuple(thing[key]) for kind, key in keys for thing in about[kind]}


@pytest.mark.slow
def test_each_seed_has_places_and_fires_of_its_own_which_every_reader_takes_from_its_record(
    workspace: Path, capsys: pytest.CaptureFixture[str]
):
    models = "model=scripted/avoid,scripted/random"
    asked = ["-m", "world=cafe_library_drawn", models, "seed=0-1", "world.steps=12", "world.agents=6"]
    assert run([*asked, "output.dir=s", "analyze=false"]) == 0
    folders = SweepFolder.open("s").runs()
    by_seed: dict[int, set[str]] = {}
    for folder in folders:
        positions = recorded_positions(folder)
        by_seed.setdefault(folder.run.seed, set()).add(str(positions))
        view = open_view(folder)
        assert shown_positions(view.about_world()) == positions
        view.close()
        world = read_run(folder, read_records(folder, folder.summary())).world
        assert {("places", place.name): place.center for place in world.places} | {
            ("fires", fire.name): fire.position for fire in world.fires
        } == positions
        frame = redrawing_of(read_recording(folder)).draw(0)
        assert frame.startswith(b"\x89PNG")
    assert [len(texts) for texts in by_seed.values()] == [1] * 2, "all models of a seed have the same positions"
    assert len(set().union(*by_seed.values())) == 2
    assert load("s").fixtures["fires"].groupby("name")["x"].nunique().max() == 2
    (folders[0].path / "run.json").unlink()
    assert run(["resume", "s"]) == 0 and statuses("s") == ["complete"] * 4
    assert run(["verify", "s", "--workers", "1"]) == 0
    assert "4 identical" in capsys.readouterr().out
    runs = analyze(["s"], plots=False).runs.set_index("model")
    assert runs.loc["scripted/avoid", "hazard.away_beyond_moved"].mean() > 0.2
    assert "hazard.away_beyond_blind" not in runs and "movement.drift_place_beyond_moved" in runs


def test_a_run_that_records_other_positions_than_its_seed_draws_is_told_as_changed(
    workspace: Path, capsys: pytest.CaptureFixture[str]
):
    asked = ["world=cafe_library_drawn", "model=scripted/random", "seed=0", "world.steps=2"]
    assert run([*asked, "output.dir=s", "analyze=false"]) == 0
    file = SweepFolder.open("s").runs()[0].path / "fixtures.jsonl"
    file.write_text(file.read_text(encoding="utf-8").replace('"name":"cafe","x":', '"name":"cafe","x":1'))
    assert run(["verify", "s", "--workers", "1"]) == 3
    assert "fixtures.jsonl" in capsys.readouterr().out
