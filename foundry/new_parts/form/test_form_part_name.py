"""The form part_name is found by its name, and its world passes all checks of worlds."""

from pathlib import Path

import pytest

import foundry

MINE = Path(__file__).parent


def test_its_world_holds_what_every_world_must_hold() -> None:
    """Every check of `foundry check` passes."""
    findings = foundry.check("world=part_name", config_dir=MINE)
    assert [finding for finding in findings if finding.status == "failed"] == []


def test_its_events_are_those_that_it_declares(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The analysis asks the form for the events of a run."""
    monkeypatch.chdir(tmp_path)
    ran = foundry.run("world=part_name", "model=scripted/random", "output.dir=out", config_dir=MINE)
    foundry.analyze(ran.path, plots=False)
    assert "opened" in set(foundry.load(ran.path).events["event"])
