"""How a run stands, in one word."""

from __future__ import annotations

from foundry.records import RunSummary
from foundry.storing.store import RunFolder

COMPLETE, FAILED = "complete", "failed"
RUNNING, UNFINISHED, WAITING = "running", "unfinished", "waiting"


def standing(folder: RunFolder, summary: RunSummary | None, *, running: bool) -> str:
    """Return `complete`, `failed`, `running`, `unfinished` (begun, and nobody plays it) or `waiting` (not begun)."""
    if summary is not None:
        return summary.status
    if not folder.beginning:
        return WAITING
    return RUNNING if running else UNFINISHED
