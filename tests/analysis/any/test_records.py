"""Runs of a form that brings no code of its own, read by what their world declares."""

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from analysis.any.any_records import AnyRecords, read_records, schema
from analysis.any.any_run import AnyRun
from analysis.measuring.steps_file import steps_table
from any_records import BAR, STREAMS, any_folder, line
from foundry.declared import Actions, Declared
from foundry.errors import RecordError
from foundry.records import Agent, Message

LINES = (
    line(1, 0, message="hi"),
    line(1, 2, action="stay", utility=None, outcome="repaired"),
    line(1, 0, kind="bid", action=3, utility=-0.5),
    line(2, 0, kind="talk", action=None, message="so?"),
    line(2, 2, action=None, outcome="unreadable"),
)
HEARD = (Message(step=1, sender=0, recipient=2, text="hi"), Message(step=2, sender=0, recipient=3, text="so?"))
PEOPLE = (Agent(agent=0, persona={"mood": "shy"}), Agent(agent=4, persona={"mood": "loud", "age": "9"}))


def read(path: Path, *lines: Any, **how: Any) -> AnyRun:
    folder = any_folder(path / "sweep", lines, **how)
    return read_records(folder, folder.summary()).arrays(folder)


def test_decisions_become_arrays_in_their_order_for_as_many_agents_as_occur_anywhere(tmp_path):
    run = read(tmp_path, *LINES, messages=HEARD, personas=PEOPLE)
    assert run.step.tolist() == [1, 1, 1, 2, 2] and run.agent.tolist() == [0, 2, 0, 0, 2]
    assert run.kind.tolist() == ["choice", "choice", "bid", "talk", "choice"]
    assert run.action.tolist() == ["go", "stay", None, None, None]
    np.testing.assert_array_equal(run.number, [np.nan, np.nan, 3, np.nan, np.nan])
    np.testing.assert_array_equal(run.utility, [1, np.nan, -0.5, 1, 1])
    assert run.said.tolist() == ["hi", None, None, "so?", None]
    assert run.deliveries.tolist() == [[1, 0, 2], [2, 0, 3]]
    assert run.readable.tolist() == [True, True, True, True, False]
    assert run.decisions == 5 and not run.all_readable
    assert run.only_readable().counted.tolist() == run.readable.tolist()
    assert run.declared == BAR and run.totals is not None
    assert run.agents == 5
    assert run.personas == ({"mood": "shy"}, {}, {}, {}, {"mood": "loud", "age": "9"})
    assert read(tmp_path / "b", *LINES, messages=HEARD).agents == 4
    assert read(tmp_path / "c").agents == 0


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"action": "fly"}, "line 2: 'fly' is not an action of its world: the declared actions are go, stay"),
        ({"action": 3}, "line 2: 3 is not an action of its world: the declared actions are go, stay"),
        ({"kind": "bid", "action": "go"}, "'go' is not an action of its world: it must be a number"),
        ({"kind": "bid", "action": 2.5}, "2.5 is not an action of its world: it must be a whole number"),
        ({"kind": "bid", "action": 11}, "11 is not an action of its world: the number must be within 0..10"),
        ({"kind": "talk"}, "'go' is not an action of its world: the world declares no kind 'talk'"),
        ({"step": 0}, r"\$\[1\].step"),
        ({"step": 3}, "the steps are not in ascending order"),
        ({"agent": -1}, r"\$\[1\].agent"),
        ({"agent": 10**7}, r"\$\[1\].agent"),
        ({"outcome": "fine"}, r"\$\[1\].outcome"),
        ({"action": True}, r"\$\[1\].action"),
        ({"utility": "much"}, r"\$\[1\].utility"),
        ({"crowd": 2**70}, r"\$\[1\].crowd"),
        ({"mood": None}, r"\$\[1\].mood"),
        ({"wants in": 3}, r"\$\[1\].wants in"),
    ],
)
def test_a_line_that_is_not_as_declared_is_an_error_that_says_where(tmp_path, changes: dict[str, Any], said: str):
    with pytest.raises(RecordError, match=said) as caught:
        read(tmp_path, line(1, 0), line(1, 1, **changes), line(2, 0))
    assert "steps.jsonl" in str(caught.value)


@pytest.mark.parametrize("missing", ["step", "agent", "action", "outcome", "kind", "crowd"])
def test_a_declared_key_that_is_missing_is_an_error(tmp_path, missing: str):
    torn = {key: value for key, value in line(1, 1).items() if key != missing}
    with pytest.raises(RecordError, match=f"missing required field `{missing}`"):
        read(tmp_path, line(1, 0), torn)


def test_an_agent_of_no_thinkable_id_in_a_message_or_a_persona_is_an_error(tmp_path):
    with pytest.raises(RecordError, match="names agent -1"):
        read(tmp_path / "a", line(1, 0), messages=[Message(step=1, sender=0, recipient=-1, text="")])
    with pytest.raises(RecordError, match="names agent 1000000000"):
        read(tmp_path / "b", line(1, 0), personas=[Agent(agent=10**9, persona={})])


def test_a_kind_that_nobody_says_is_the_one_that_there_is(tmp_path):
    silent = {key: value for key, value in line(1, 0).items() if key != "kind"}
    streams = {"steps": {key: kind for key, kind in STREAMS["steps"].items() if key != "kind"}}
    declared = Declared(form="ring", actions={"choice": BAR.actions["choice"]}, streams=streams)
    assert read(tmp_path / "a", silent, declared=declared).kind.tolist() == ["choice"]
    with pytest.raises(RecordError, match="declares several: choice, bid"):
        read(tmp_path / "b", silent, declared=Declared(form="ring", actions=BAR.actions, streams=streams))


def test_a_world_that_declares_nothing_is_read_by_the_common_keys(tmp_path):
    run = read(tmp_path, {"step": 1, "agent": 0, "action": "any", "outcome": "chosen", "x": [1]}, declared=None)
    assert run.kind.tolist() == ["action"] and run.action.tolist() == ["any"] and run.declared.form == "any"


def test_lines_of_an_old_world_that_are_no_decisions_are_rows_all_the_same(tmp_path):
    folder = any_folder(tmp_path / "sweep", [{"step": 1, "went": True}, {"step": 2, "price": 3}], declared=None)
    records = read_records(folder, folder.summary())
    assert records.rows() == [{"step": 1, "went": True, "price": None}, {"step": 2, "went": None, "price": 3}]
    assert "missing required field `agent`" in records.unfit
    with pytest.raises(RecordError, match="missing required field `agent`"):
        records.arrays(folder)


def test_the_torn_last_line_of_a_run_that_goes_on_is_left_out(tmp_path):
    folder = any_folder(tmp_path / "sweep", LINES, ended=False)
    with folder.stream_path("steps").open("ab") as file:
        file.write(b'{"step": 2, "ag')
    assert [row["step"] for row in read_records(folder, None).rows()] == [1, 1, 1, 2, 2]


def test_a_file_that_is_not_the_one_that_was_written_is_an_error(tmp_path):
    folder = any_folder(tmp_path / "sweep", LINES)
    folder.stream_path("steps").write_bytes(b"")
    with pytest.raises(RecordError, match="was changed after the run"):
        read_records(folder, folder.summary())


def test_the_columns_of_a_table_are_numbers_flags_and_labels_and_never_a_text_even_of_no_lines(tmp_path):
    folder = any_folder(tmp_path / "sweep", LINES)
    table = steps_table("r", read_records(folder, folder.summary()), schema(folder.declared))
    common = ["run", "step", "agent", "kind", "action", "action_number", "outcome", "utility", "said"]
    assert table.schema.remove(0) == schema(BAR) and table.column_names == [*common, "mood", "crowd", "wants in"]
    assert table.schema.field("crowd").type == pa.int64() and table.schema.field("wants in").type == pa.bool_()
    assert table["action"].to_pylist() == ["go", "stay", None, None, None]
    assert table["action_number"].to_pylist() == [None, None, 3.0, None, None]
    assert table["said"].to_pylist() == [True, False, False, True, False]
    assert steps_table("r", AnyRecords(BAR, [], []), schema(BAR)).column_names == ["run", *schema(BAR).names]


def test_declared_ranges_may_be_open(tmp_path):
    free = Declared(form="ring", actions={"bid": Actions(whole=False)}, streams=STREAMS)
    run = read(tmp_path, line(1, 0, kind="bid", action=-1e300), declared=free)
    assert run.number.tolist() == [-1e300]
