from pathlib import Path

import msgspec
import pytest

from foundry.storing import run_writer
from foundry.storing.store import RunFolder
from foundry.viewer.calls import CallLog
from made_up_runs import AGENTS, Playing, sweep, whole_run


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    return sweep(tmp_path / "sweep").runs()[0]


def found(log: CallLog, agent: int, first: int, last: int) -> list[tuple[int, int, str]]:
    decoded = [msgspec.json.decode(line) for line in log.of_agent(agent, first, last)]
    return [(one["step"], one["agent"], one["kind"]) for one in decoded]


@pytest.mark.parametrize("frame", [1, 2000, 1 << 30])
def test_a_step_is_found_in_any_order_wherever_frames_of_the_log_end(
    frame: int, folder: RunFolder, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(run_writer, "FRAME", frame)
    whole_run(folder, reply="x" * 100_000)
    log = CallLog(folder.stream_path("calls"))
    for step in (6, 1, 2, 5, 3, 4):
        assert found(log, 3, step, step) == [(step, 3, "message"), (step, 3, "action")]
    assert [call.step for call in folder.calls()] == sorted(list(range(1, 7)) * AGENTS * 2)
    assert found(log, 2, 1, 6) == [(step, 2, kind) for step in range(1, 7) for kind in ("message", "action")]
    assert found(log, 9, 1, 6) == []
    log.close()
    assert found(log, 1, 6, 6) == [(6, 1, "message"), (6, 1, "action")]


def test_a_late_step_is_read_without_the_steps_before_it(folder: RunFolder, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(run_writer, "FRAME", 1)
    whole_run(folder)
    path = folder.stream_path("calls")
    content = bytearray(path.read_bytes())
    second = content.index(b"\x28\xb5\x2f\xfd", 1)
    content[second - 20 : second] = b"damaged" + bytes(13)  # in the calls of the first step
    path.write_bytes(content)
    log = CallLog(path)
    assert found(log, 1, 6, 6) == [(6, 1, "message"), (6, 1, "action")] and log.damaged == ""
    assert found(log, 1, 1, 6) == [] and log.damaged


@pytest.mark.parametrize("frame", [1, 4000, run_writer.FRAME])
def test_a_log_that_grows_is_followed(frame: int, folder: RunFolder, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(run_writer, "FRAME", frame)
    log = CallLog(folder.stream_path("calls"))
    assert log.of_agent(0, 1, 1) == []
    playing = Playing(folder)
    for number in range(1, 4):
        playing.play(number, number)
        assert found(log, 1, number, number) == [(number, 1, "message"), (number, 1, "action")]
        assert found(log, 1, 1, 1) == [(1, 1, "message"), (1, 1, "action")]
    playing.play(4, 9)
    assert len(found(log, 1, 2, 9)) == 16
    playing.end()


def test_a_log_that_was_cut_gives_what_is_whole_and_one_that_is_none_is_said_to_be_damaged(folder: RunFolder):
    whole_run(folder)
    path = folder.stream_path("calls")
    path.write_bytes(path.read_bytes()[:-40])
    log = CallLog(path)
    assert found(log, 0, 1, 1) == [(1, 0, "message"), (1, 0, "action")]
    assert log.damaged == ""
    path.write_bytes(b"this is no log")
    log = CallLog(path)
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
    assert "a lower step than the call before" in log.damaged and '"step":1' in log.damaged
