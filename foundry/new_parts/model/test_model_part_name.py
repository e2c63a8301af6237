"""The model part_name passes all checks of models, and plays an episode."""

from pathlib import Path

import pytest

import foundry

MINE = Path(__file__).parent
SMALL = ("world.agents=4", "world.steps=3")


def test_it_holds_what_every_model_must_hold() -> None:
    """Every check of `foundry check` passes; the model is not asked."""
    findings = foundry.check("model=part_name", *SMALL, config_dir=MINE)
    assert [finding for finding in findings if finding.status == "failed"] == []


def test_it_plays_an_episode(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All replies of the model can be read."""
    monkeypatch.chdir(tmp_path)
    ran = foundry.run("model=part_name", "output.dir=out", *SMALL, config_dir=MINE)
    assert (ran.complete, ran.failed) == (1, ())
    assert set(foundry.load(ran.path).steps["outcome"]) <= {"chosen", "repaired"}
