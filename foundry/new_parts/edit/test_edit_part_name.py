"""The edit part_name passes all checks of edits, and makes the intended change."""

from pathlib import Path

import foundry

MINE = Path(__file__).parent


def test_it_holds_what_every_edit_must_hold() -> None:
    """Every check of `foundry check` passes."""
    findings = foundry.check("edit=part_name", config_dir=MINE)
    assert [finding for finding in findings if finding.status == "failed"] == []
