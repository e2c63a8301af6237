"""The policy part_name passes all checks of policies, and acts as intended."""

from pathlib import Path

import pytest

import foundry

MINE = Path(__file__).parent
SMALL = ("world.agents=4", "world.steps=3")


def test_it_holds_what_every_policy_must_hold() -> None:
    """Every check of `foundry check` passes."""
    findings = foundry.check("model=part_name", *SMALL, config_dir=MINE)
    assert [finding for finding in findings if finding.status == "failed"] == []


def test_it_goes_to_the_right(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In every step, each agent moves to the right or stays."""
    monkeypatch.chdir(tmp_path)
    ran = foundry.run("model=part_name", "output.dir=out", *SMALL, config_dir=MINE)
    assert ran.failed == ()
    steps = foundry.load(ran.path).steps
    assert set(steps["x_next"] - steps["x"]) <= {0, 1}
