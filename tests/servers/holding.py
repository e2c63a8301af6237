"""What tests of crashes share: calls that are held back, and the proof that nothing was lost, paid twice or changed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from commands import SMALL, calls, records, statuses
from foundry.storing.store import SweepFolder
from ollama_cases import Body, ChatCase, grid_answer
from ollama_server import OllamaServer

SWEEP = ("-m", "model=qwen3:4b", "seed=0-5", *SMALL)
CALLS = 6 * 4 * 4 * 2


class Holding:
    """Answers the first `count` calls and holds every later one back, until `free`."""

    def __init__(self, count: int) -> None:
        self.left = count
        self.held = False

    def __call__(self, body: Body) -> str | ChatCase:
        if self.left > 0:
            self.left -= 1
            return grid_answer(body)
        self.held = True
        return ChatCase(hang=True)

    def free(self) -> None:
        self.left = 10**9


def working(folder: Path) -> list[dict[str, Any]]:
    """Return the reports of the workers that have a run open."""
    return [report for report in SweepFolder.open(folder).progress().values() if report["open"]]


def assert_nothing_lost_or_paid_twice(server: OllamaServer, folder: Path, undisturbed: Path) -> None:
    assert set(statuses(folder)) == {"complete"}
    assert set(server.answered.values()) == {1}
    assert len(server.answered) == CALLS
    assert records(folder) == records(undisturbed)
    assert calls(folder) == calls(undisturbed)
