from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from foundry.errors import RecordError
from foundry.viewer import lines
from foundry.viewer.lines import StepLines, by_agent, lines_of_agent


def encoded(rows: list[tuple[int, int]], text: str = "") -> bytes:
    return b"".join(msgspec.json.encode({"step": step, "agent": agent, "text": text}) + b"\n" for step, agent in rows)


def grown(path: Path, content: bytes) -> StepLines:
    path.write_bytes(content)
    found = StepLines(path)
    found.grow()
    return found


def test_the_lines_of_a_range_of_steps_are_found_and_steps_without_any_skipped(tmp_path: Path):
    rows = [(step, agent) for step in range(1, 6) for agent in range(3)]
    found = grown(tmp_path / "steps.jsonl", encoded(rows))
    assert found.read(2, 3) == encoded([row for row in rows if row[0] in (2, 3)])
    assert found.last == (5, 3) and found.in_first == 3
    found = grown(tmp_path / "messages.jsonl", encoded([(2, 0), (7, 0), (7, 1)]))
    assert found.read(3, 6) == b""
    assert found.read(1, 7) == encoded([(2, 0), (7, 0), (7, 1)])
    found = StepLines(tmp_path / "absent.jsonl")
    found.grow()
    assert found.last == (0, 0)
    assert found.read(1, 5) == b""


def test_few_looks_find_where_steps_of_many_lines_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    looks, look = [], StepLines._step_at
    monkeypatch.setattr(StepLines, "_step_at", lambda *asked: looks.append(asked) or look(*asked))
    rows = [(step, agent) for step in range(1, 5) for agent in range(5000)]
    found = grown(tmp_path / "steps.jsonl", encoded(rows))
    assert found.read(3, 3) == encoded(rows[10_000:15_000])
    assert len(looks) < 150


def test_a_torn_line_is_not_seen_until_whole_and_a_run_started_anew_is_read_anew(tmp_path: Path):
    path, content = tmp_path / "steps.jsonl", encoded([(1, 0), (1, 1)])
    found = grown(path, content[:-4])
    assert found.last == (1, 1)
    path.write_bytes(content)
    found.grow()
    assert found.last == (1, 2)
    assert found.read(1, 1) == content
    path = tmp_path / "steps.jsonl"
    found = grown(path, encoded([(1, 0), (2, 0), (3, 0)]))
    path.write_bytes(encoded([(1, 0)]))
    found.grow()
    assert found.last == (1, 1)


@pytest.mark.parametrize("content", [b'{"agent":0,"step":1}\n', b"\n", b"nonsense\n"])
def test_a_line_that_does_not_begin_with_its_step_is_an_error(tmp_path: Path, content: bytes):
    with pytest.raises(RecordError, match="does not begin with its step"):
        grown(tmp_path / "steps.jsonl", content)


def test_no_text_looks_like_the_line_of_another_agent():
    content = encoded([(1, 0)], text='\n{"step":1,"agent":1,"x":0}\n') + encoded([(1, 1)], text="mine")
    (line,) = lines_of_agent(content, 1)
    assert msgspec.json.decode(line)["text"] == "mine"
    assert lines_of_agent(content, 7) == []
    assert by_agent(content)[1] == [line]


def test_an_agents_lines_are_found_in_steps_with_many_with_none_and_with_others_inside_them():
    inside = b'{"step":2,"agent":0,"seen":[{"step":4,"agent":1,"text":""}]}\n'
    content = encoded([(1, 0), (1, 1), (1, 1)]) + inside + encoded([(4, 1), (4, 0), (4, 1), (6, 1)])
    mine = [
        line
        for line in content.splitlines()
        if line.startswith((b'{"step":1,"agent":1,', b'{"step":4,"agent":1,', b'{"step":6,'))
    ]
    assert lines_of_agent(content, 1) == mine and len(mine) == 5


@given(counts=st.lists(st.integers(0, 5), max_size=12), cuts=st.lists(st.integers(0, 2000), max_size=4))
def test_lines_are_found_however_the_file_grows(
    tmp_path_factory: pytest.TempPathFactory, counts: list[int], cuts: list[int]
):
    rows = [(step, agent) for step, count in enumerate(counts, 1) for agent in range(count)]
    content, path = encoded(rows), tmp_path_factory.mktemp("grows") / "steps.jsonl"
    found = StepLines(path)
    for cut in [*sorted(cuts), len(content)]:
        path.write_bytes(content[:cut])
        found.grow()
    for step, count in enumerate(counts, 1):
        assert found.read(step, step) == encoded([(step, agent) for agent in range(count)])


def test_a_line_longer_than_a_block_is_whole(tmp_path: Path):
    content = encoded([(1, 0)], text="x" * (lines.BLOCK + 10)) + encoded([(2, 0)])
    found = grown(tmp_path / "steps.jsonl", content)
    assert found.read(1, 2) == content


@pytest.mark.parametrize("steps", [[1, 3, 2], [2, 1]])
def test_steps_that_go_back_within_what_is_read_at_once_are_an_error(steps: list[int], tmp_path: Path):
    with pytest.raises(RecordError, match="comes after step"):
        grown(tmp_path / "steps.jsonl", encoded([(one, 0) for one in steps]))


def test_a_step_that_goes_back_later_is_an_error_and_one_that_goes_on_is_counted(tmp_path: Path):
    path = tmp_path / "steps.jsonl"
    found = grown(path, encoded([(1, 0), (2, 0)]))
    path.write_bytes(encoded([(1, 0), (2, 0), (2, 1)]))
    found.grow()
    assert found.in_first == 1 and found.last == (2, 2)
    path.write_bytes(encoded([(1, 0), (2, 0), (2, 1), (1, 1)]))
    with pytest.raises(RecordError, match="step 1 comes after step 2"):
        found.grow()
