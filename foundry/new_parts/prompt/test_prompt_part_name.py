"""The prompt part_name passes all checks of prompts."""

from pathlib import Path

import foundry

MINE = Path(__file__).parent


def test_it_holds_what_every_prompt_must_hold() -> None:
    """Every check of `foundry check` passes, on the questions of a 2D world."""
    findings = foundry.check("prompt=part_name", "world.agents=6", "world.steps=6", config_dir=MINE)
    assert [finding for finding in findings if finding.status == "failed"] == []
