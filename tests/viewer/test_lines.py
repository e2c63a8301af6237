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
    step_lines = StepLines(path)
    step_lines.grow()
    return step_lines


def test_the_lines_of_a_range_of_steps_are_found_and_steps_without_any_skipped(tmp_path: Path):
    rows = [(step, agent) for step in range(1, 6) for agent in range(3)]
    step_lines = grown(tmp_path / "steps.jsonl", encoded(rows))
    assert step_lines.read(2, 3) == encoded([row for row in rows if row[0] in (2, 3)])
    assert step_lines.last == (5, 3) and step_lines.in_first == 3
    step_lines = grown(tmp_path / "messages.jsonl", encoded([(2, 0), (7, 0), (7, 1)]))
    assert step_lines.read(3, 6) == b""
    assert step_lines.read(1, 7) == encoded([(2, 0), (7, 0), (7, 1)])
    step_lines = StepLines(tmp_path / "absent.jsonl")
    step_lines.grow()
    assert step_lines.last == (0, 0)
    assert step_lines.read(1, 5) == b""


def test_a_torn_line_is_not_seen_until_whole_and_a_run_started_anew_is_read_anew(tmp_path: Path):
    path, content = tmp_path / "steps.jsonl", encoded([(1, 0), (1, 1)])
    step_lines = grown(path, content[:-4])
    assert step_lines.last == (1, 1)
    path.write_bytes(content)
    step_lines.grow()
    assert step_lines.last == (1, 2)
    assert step_lines.read(1, 1) == content
    path = tmp_path / "steps.jsonl"
    step_lines = grown(path, encoded([(1, 0), (2, 0), (3, 0)]))
    path.write_bytes(encoded([(1, 0)]))
    step_lines.grow()
    assert step_lines.last == (1, 1)


def test_the_lines_of_an_agent_are_found_and_no_text_or_inner_record_looks_like_one():
    inside = b'{"step":2,"agent":0,"seen":[{"step":4,"agent":1,"text":""}]}\n'
    first = encoded([(1, 0)], text='\n{"step":1,"agent":1,"x":0}\n')
    content = first + encoded([(1, 1), (1, 1)]) + inside + encoded([(4, 1), (4, 0), (4, 1), (6, 1)])
    mine = encoded([(1, 1), (1, 1), (4, 1), (4, 1), (6, 1)]).splitlines()
    assert lines_of_agent(content, 1) == by_agent(content)[1] == mine
    assert lines_of_agent(content, 7) == []


@given(counts=st.lists(st.integers(0, 5), max_size=12), cuts=st.lists(st.integers(0, 2000), max_size=4))
def test_lines_are_found_however_the_file_grows(
    tmp_path_factory: pytest.TempPathFactory, counts: list[int], cuts: list[int]
):
    rows = [(step, agent) for step, count in enumerate(counts, 1) for agent in range(count)]
    content, path = encoded(rows), tmp_path_factory.mktemp("grows") / "steps.jsonl"
    step_lines = StepLines(path)
    for cut in [*sorted(cuts), len(content)]:
        path.write_bytes(content[:cut])
        step_lines.grow()
    for step, count in enumerate(counts, 1):
        assert step_lines.read(step, step) == encoded([(step, agent) for agent in range(count)])


def test_a_line_longer_than_a_block_is_whole(tmp_path: Path):
    content = encoded([(1, 0)], text="x" * (lines.BLOCK + 10)) + encoded([(2, 0)])
    step_lines = grown(tmp_path / "steps.jsonl", content)
    assert step_lines.read(1, 2) == content


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b'{"agent":0,"step":1}\n', "does not begin with its step"),
        (b"\n", "does not begin with its step"),
        (encoded([(1, 0), (3, 0), (2, 0)]), "comes after step"),
        (encoded([(2, 0), (1, 0)]), "comes after step"),
    ],
)
def test_lines_without_a_step_and_steps_that_go_back_are_an_error(content: bytes, said: str, tmp_path: Path):
    with pytest.raises(RecordError, match=said):
        grown(tmp_path / "steps.jsonl", content)


def test_a_step_that_goes_back_later_is_an_error_and_one_that_goes_on_is_counted(tmp_path: Path):
    path = tmp_path / "steps.jsonl"
    step_lines = grown(path, encoded([(1, 0), (2, 0)]))
    path.write_bytes(encoded([(1, 0), (2, 0), (2, 1)]))
    step_lines.grow()
    assert step_lines.in_first == 1 and step_lines.last == (2, 2)
    path.write_bytes(encoded([(1, 0), (2, 0), (2, 1), (1, 1)]))
    with pytest.raises(RecordError, match="step 1 comes after step 2"):
        step_lines.grow()
