"""The world part_name passes all checks of worlds, and follows its own rules."""

from pathlib import Path

import pytest

import foundry

MINE = Path(__file__).parent


def test_it_holds_what_every_world_must_hold() -> None:
    """Every check of `foundry check` passes."""
    findings = foundry.check("world=part_name", config_dir=MINE)
    assert [finding for finding in findings if finding.status == "failed"] == []


def test_who_gives_nothing_keeps_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """If no agent gives tokens, each agent keeps all of its tokens."""
    monkeypatch.chdir(tmp_path)
    ran = foundry.run("world=part_name", "model=scripted/stay", "output.dir=out", config_dir=MINE)
    assert (ran.complete, ran.failed) == (1, ())
    assert set(foundry.load(ran.path).steps["utility"]) == {10.0}
