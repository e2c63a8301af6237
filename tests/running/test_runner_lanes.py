"""A worker in a process of its own: its result, its errors and its death reach whoever waits."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from foundry.errors import FoundryError
from foundry.expansion import Sweep
from foundry.running.lane import LaneSpec
from foundry.running.lane_process import LaneProcess, WorkerDied
from foundry.storing.store import SweepFolder
from lane_works import blocked, dying, echoing, failing, waiting

SPEC = LaneSpec("0-0", "0", SweepFolder(Path("sweep"), Sweep((), (), ()), {}, []), (), {}, cache="")


@pytest.fixture(autouse=True)
def found_by_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "parts"))


def test_an_error_comes_back_as_itself():
    with pytest.raises(FoundryError, match="no luck with 0-0"):
        LaneProcess(failing, SPEC).ended.result()


def test_a_death_is_told():
    with pytest.raises(WorkerDied, match=str(-signal.SIGKILL)):
        LaneProcess(dying, SPEC).ended.result()


def test_a_killed_process_ends():
    process = LaneProcess(waiting, SPEC)
    process.kill()
    with pytest.raises(WorkerDied, match=str(-signal.SIGKILL)):
        process.ended.result()


def test_ctrl_c_does_not_reach_a_worker_from_its_first_instruction_on():
    assert LaneProcess(blocked, SPEC).ended.result() == "blocked"


def test_a_result_comes_back_whatever_is_printed_or_lies_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "asyncio.py").write_text("raise RuntimeError('not that one')")
    monkeypatch.chdir(tmp_path)
    assert LaneProcess(echoing, SPEC).ended.result() == "0-0"
