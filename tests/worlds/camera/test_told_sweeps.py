"""Whole sweeps of the worlds that are made from labels: played, measured, reported and played again."""

from __future__ import annotations

from pathlib import Path

import pytest

from analysis import analyze
from foundry.cli import run
from labelled_rooms import TINY, write_rooms


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("world", "models", "column", "expected"),
    [
        ("follow", "scripted/oracle,scripted/stay", "path_efficiency.success", [1.0, 1.0, 0.0, 0.0]),
        ("map_probe", "scripted/knower,scripted/random", "map_probe.accuracy", [1.0, 1.0]),
    ],
)
def test_a_sweep_is_played_measured_and_reported(
    workspace: Path, world: str, models: str, column: str, expected: list[float]
):
    scene = write_rooms(workspace / "rooms.usda")
    asked = ["-m", f"world={world}", f"scene='{scene}'", f"model={models}", "seed=0-1", *TINY, "runner.workers=1"]
    assert run([*asked, "analyze=false", "output.dir=sweep"]) == 0
    runs = analyze([Path("sweep")], plots=False).runs.sort_values(["model", "seed"], ignore_index=True)
    assert runs[column].tolist()[: len(expected)] == expected
    assert run(["report", "sweep"]) == 0 and (workspace / "sweep" / "report.html").is_file()
    assert run(["verify", "sweep"]) == 0
