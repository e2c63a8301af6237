from __future__ import annotations

import tracemalloc
from pathlib import Path

import msgspec
import pytest

from foundry.storing.store import RunFolder
from foundry.viewer import calls
from foundry.viewer.calls import CallLog
from made_up_runs import AGENTS, Playing, sweep


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    return sweep(tmp_path / "sweep").runs()[0]


def found(log: CallLog, agent: int, first: int, last: int) -> list[tuple[int, int, str]]:
    decoded = [msgspec.json.decode(line) for line in log.of_agent(agent, first, last)]
    return [(one["step"], one["agent"], one["kind"]) for one in decoded]


def test_the_calls_of_an_agent_are_found_in_any_order(folder: RunFolder):
    playing = Playing(folder)
    playing.play(1, 6)
    playing.end()
    log = CallLog(folder.stream_path("calls"))
    assert found(log, 2, 5, 5) == [(5, 2, "message"), (5, 2, "action")]
    assert found(log, 0, 1, 2) == [(1, 0, "message"), (1, 0, "action"), (2, 0, "message"), (2, 0, "action")]
    assert found(log, 9, 1, 6) == []
    log.close()
    assert found(log, 1, 6, 6) == [(6, 1, "message"), (6, 1, "action")]


@pytest.mark.parametrize("block", [1, 2000, 300_000])
def test_a_long_log_is_kept_compressed_and_going_back_costs_a_block(
    block: int, folder: RunFolder, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(calls, "BLOCK", block)
    playing = Playing(folder, reply="x" * 100_000)
    playing.play(1, 6)
    playing.end()
    log = CallLog(folder.stream_path("calls"))
    tracemalloc.start()
    try:
        assert found(log, 3, 6, 6) == [(6, 3, "message"), (6, 3, "action")]
        assert tracemalloc.get_traced_memory()[0] < 1_000_000 < 6 * AGENTS * 2 * 100_000
    finally:
        tracemalloc.stop()
    for step in range(1, 7):
        assert found(log, 3, step, step) == [(step, 3, "message"), (step, 3, "action")]


def test_a_log_that_grows_is_followed(folder: RunFolder):
    log = CallLog(folder.stream_path("calls"))
    assert log.of_agent(0, 1, 1) == []
    playing = Playing(folder)
    for number in range(1, 4):
        playing.play(number, number)
        assert found(log, 1, number, number) == [(number, 1, "message"), (number, 1, "action")]
    playing.end()


def test_a_log_cut_by_a_crash_gives_what_is_whole(folder: RunFolder):
    playing = Playing(folder)
    playing.play(1, 6)
    playing.end()
    path = folder.stream_path("calls")
    path.write_bytes(path.read_bytes()[:-40])
    log = CallLog(path)
    assert found(log, 0, 1, 1) == [(1, 0, "message"), (1, 0, "action")]
    assert log.damaged == ""


def test_a_log_that_is_none_is_said_to_be_damaged(folder: RunFolder):
    folder.path.mkdir(parents=True)
    folder.stream_path("calls").write_bytes(b"this is no log")
    log = CallLog(folder.stream_path("calls"))
    assert log.of_agent(0, 1, 1) == []
    assert log.damaged


def test_a_call_of_a_step_that_is_over_is_said_and_what_was_before_it_is_shown(folder: RunFolder):
    playing = Playing(folder)
    playing.play(1, 2)
    playing.play(1, 1)
    playing.play(3, 3)
    playing.end()
    log = CallLog(folder.stream_path("calls"))
    assert found(log, 0, 2, 3) == [(2, 0, "message"), (2, 0, "action")]
    assert "a step that is due" in log.damaged and '"step":1' in log.damaged
