"""The signature part_name passes all checks of signatures, and counts correctly."""

from pathlib import Path

import pytest

import foundry

MINE = Path(__file__).parent
SMALL = ("world.agents=4", "world.steps=3")


def test_it_holds_what_every_signature_must_hold() -> None:
    """Every check of `foundry check` passes."""
    findings = foundry.check("part_name", *SMALL, config_dir=MINE)
    assert [finding for finding in findings if finding.status == "failed"] == []


def test_who_always_does_the_same_has_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """If all decisions of a run are the same, the most frequent action has the share 1."""
    monkeypatch.chdir(tmp_path)
    ran = foundry.run("model=scripted/stay", "output.dir=out", *SMALL, config_dir=MINE)
    table = foundry.analyze(ran.path, plots=False).runs
    assert list(table["part_name.commonest"]) == [1.0]
