"""The edit part_name holds what every edit must hold, and changes what it says."""

from pathlib import Path

import foundry

MINE = Path(__file__).parent


def test_it_holds_what_every_edit_must_hold() -> None:
    """Every check of `foundry check` passes."""
    findings = foundry.check("edit=part_name", config_dir=MINE)
    assert [finding for finding in findings if finding.status == "failed"] == []
