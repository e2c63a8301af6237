"""A worker in a process of its own: its result, its errors and its death reach whoever waits."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from joblib.externals.loky.process_executor import BrokenProcessPool

from foundry.errors import FoundryError
from foundry.lane import LaneSpec
from foundry.lane_process import LaneProcess
from foundry.store import SweepFolder
from foundry.sweep import Sweep
from lane_works import dying, echoing, failing

SPEC = LaneSpec("0-0", SweepFolder(Path("sweep"), Sweep((), (), ()), {}, []), (), {}, cache="")


@pytest.fixture
def process():
    one = LaneProcess()
    yield one
    one.shutdown(wait=True, kill_workers=True)


@pytest.fixture(autouse=True)
def found_by_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))


def test_a_result_comes_back_whatever_is_printed_meanwhile(process: LaneProcess):
    assert process.submit(echoing, SPEC).result(timeout=60) == "0-0"


def test_an_error_comes_back_as_itself(process: LaneProcess):
    with pytest.raises(FoundryError, match="no luck with 0-0"):
        process.submit(failing, SPEC).result(timeout=60)


def test_a_death_is_told(process: LaneProcess):
    with pytest.raises(BrokenProcessPool, match=str(-signal.SIGKILL)):
        process.submit(dying, SPEC).result(timeout=60)
