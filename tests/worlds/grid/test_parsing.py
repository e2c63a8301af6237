"""Decisions and messages are read as they are meant, and none is made up.

A label of `replies_*.jsonl` is what a person reads: an action and its direction, a message (null: silence), or null
where nothing can be told. Others than those who labelled wrote the rules; they never looked at `replies_held.jsonl`.
"""

import json
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foundry.paths import conf_dir
from foundry.records import Outcome
from foundry.worlds.base import Answer
from foundry.worlds.grid.parsing import ActionReading, read_action, read_message
from foundry.worlds.grid.words import MEANINGS, MOVE, STAY, is_placeholder
from foundry.worlds.mending import LONGEST, MOST_BRACKETS

CHOSEN, REPAIRED, UNREADABLE = Outcome.CHOSEN, Outcome.REPAIRED, Outcome.UNREADABLE
UP = '{"action": "move", "direction": "up", "memory": "m", "reasoning": "r"}'
DOWN = UP.replace("up", "down")
HELLO = '{"message": "hello", "reasoning": "r"}'

OCCURS = {
    "up": r"up|north|y ?\+ ?1|↑",
    "down": r"down|south|y ?- ?1|↓",
    "left": r"left|west|x ?- ?1|←",
    "right": r"right|east|x ?\+ ?1|→",
}


DECISIONS = {
    ("move", "up", CHOSEN): [UP, f"\n {UP} \n"],
    ("stay", None, CHOSEN): ['{"action": "stay"}', '{"action": "stay", "direction": "up", "memory": null}',
        '{"action": "stay", "direction": [1], "mood": "fine"}', '{"action": "stay", "memory": "<think>"}'],
    ("move", "up", REPAIRED): [f"```json\n{UP}\n```", f"I go up.\n{UP}\nThat is all.", f"[{UP}]",
        f"<think>down? {DOWN}</think>{UP}", f"down? {DOWN}</think>{UP}", f"{UP} {UP}",
        "{'action': 'move', 'direction': 'up', 'memory': None, 'ok': True,}", '{"action": "move", "direction": "up",}',
        '{"Action": "MOVE", "direction ": " Up "}', '{"action": "go", "direction": "north"}', '{"action": "up"}',
        '{"action": "move up", "direction": null}', '{"action": "move" or "stay"}\nSo: ' + UP,
        '\\boxed{x} \\frac{a}{b} ' + UP, '{"action": ["move"], "direction": ["up"]}',
        '{"action": {"type": "move", "direction": "up"}}', '{"plan": ' + UP + "}",
        '{"action": "move" "direction": "up"}', '{action: move, direction: up}',
        '{"action": "move", // or so\n "direction": "up", # Y+1\n "memory": "m" /* end */}',
        '{“action”: “move”, “direction”: “up”, “memory”: “it’s near”}', '{"action"："move"，"direction"："up"}',
        '{\\"action\\": \\"move\\", \\"direction\\": \\"up\\"}',
        '{"action": "move", "direction": "up", "memory": "he said "no", twice"}',
        "{'action': 'move', 'direction': 'up', 'memory': 'I'm near'}",
        '{"action": "move", "direction": "up", "memory": "I am', '"action": "move",\n"direction": "up"',
        "Sure.\n\n**Action:** move\n**Direction:** Up (Y+1)\n\n**Memory:** m",
        "**Action:** move\n**Direction:** up\n" + UP, "Action: move, Direction: up",
        "<action>move</action>\n<direction>up</direction>", '{"action": "move", "direction": "Y + 1"}',
        '{"action": "move", "direction": "⬆️"}', '{"行動": "移動", "方向": "上"}', '{"action": "向上移动"}',
        "### Action\nmove\n\n### Direction\nup", "<thought>{'action': 'stay'}</thought>" + UP,
        '{"action": "идти", "direction": "вверх"}'],
    ("stay", None, REPAIRED): ['{"action": "stay", "memory": "two\nlines"}', '{"action": "wait"}',
        '{"action": "stay", "memory": NaN}', '{"step": 3, "decision": {"action": "stay"}}', '{"action": "stay", "dir',
        '{"action": "stay", "direction": ', "- action: stay\n- direction: null",
        '{"action": "remain at current position"}', '{"action": "do not move", "direction": null}'],
    ("move", "left", REPAIRED): ['{"action": "walk", "direction": "leftwards"}',
        '{"action": "gehen", "direction": "nach links"}'],
    ("move", "right", REPAIRED): ['{"action": "move to the right", "direction": "right"}',
        '{"action": "move", "direction": "right, towards the library"}', '{"action": "move", "direction": "à droite"}',
        '{"action": "MOVE_RIGHT"}'],
    ("move", "down", REPAIRED): ['{"action": "move", "direction": "down (Y-1)"}',
        '{"action": "move", "direction": "Y = Y - 1"}'],
}  # fmt: skip


def decision(reading: ActionReading) -> tuple[Any, ...]:
    return reading.action, reading.direction, reading.outcome


def misread(table: dict[Any, list[str]], read: Callable[[Answer], Any]) -> dict[str, Any]:
    """Return what is read of each text of a table that is read otherwise than the table says."""
    return {text: found for asked, texts in table.items() for text in texts if (found := read(Answer(text))) != asked}


def test_decisions_are_read():
    assert misread(DECISIONS, lambda answer: decision(read_action(answer))) == {}


NO_DECISION = [
    "move up", "{}", "[]", "null", '{"action": "move"}', '{"action": "move", "direction": null}',
    '{"action": "move", "direction": "up or down"}', '{"action": "move", "direction": "up", "action": "stay"}',
    '{"Action": "move", "action": "stay", "direction": "up"}', '{"action": "move up", "direction": "down"}',
    '{"action": "up", "direction": "sideways"}', '{"action": "do not move", "direction": "up"}',
    '{"action": "stay or move", "direction": "up"}', '{"action": "не up"}', '{"direction": "up"}',
    '{"plan": ' + UP + ', "action": st', f"{UP} or {DOWN}", UP + ' {"action": "fly"}', UP * 40,
    '{"action": "move", "direction": "up", "down", "left", or "right", "memory": "m"}',
    '{"action": "move", "direction": "up" "down"}', '{"action": "move", "direction": up, down, "memory": "m"}',
    "{'action': 'move', 'direction': 'up', 'down', 'left', 'right', 'memory': 'm'}",
    '{"action": "move", "direction": "up"/"down", "memory": "m"}',
    '{"action": "move", "direction": "up" // or "down"\n}', '{"action": "move", "stay", "direction": "up"}',
    '{"action": "move", "direction": "up"\n{"action": "stay"}',
    '{"action": "move", "direction": "up"\n"direction": "down"}',
    '{"action": "move" "direction": "up"} {"action": "stay"}', '{"action": "move", "direction": "up',
    '{"action": "move", "direction": up', '{"action": "move", "direction": ["up", "left"]}',
    '{"action": "move", "direction": "up (or down)"}', '{"action": "move", "direction": "up?"}',
    '{"action": "move", "direction": "right (X-1)"}', '{"action": "move", "direction": "northeast"}',
    '{"action": "move", "direction": "左下"}', '{"action": "move", "direction": "left of the bar"}',
    '{"action": "move", "direction": "not up"}', '{"action": "stay away"}', '{"previous_action": ' + UP + "}",
    '{"memory": ' + UP + "}", '{"first": ' + UP + ', "second": ' + DOWN + "}",
    "action: move\naction: stay\ndirection: up", "action: move or stay\ndirection: up",
    "**Action:** move\n**Direction:** down\n" + UP, "Action: <action>",
]  # fmt: skip


def test_nothing_is_invented():
    assert misread({("stay", None, UNREADABLE): NO_DECISION}, lambda answer: decision(read_action(answer))) == {}
    for text in NO_DECISION:
        reading = read_action(Answer(text))
        assert (reading.memory, reading.reasoning) == ("", "")
        assert read_action(Answer(text, ending="length")).outcome is Outcome.TRUNCATED


MESSAGES = {
    ("hello", CHOSEN): [HELLO, '{"message": "hello"}'],
    (None, CHOSEN): ['{"message": null}', '{"message": " ", "reasoning": "r"}', '{"reasoning": "r"}'],
    ('{"action": 1}', CHOSEN): ['{"message": "{\\"action\\": 1}"}'],
    ("\ufffd!", CHOSEN): ['{"message": "\\ud800!", "reasoning": "r"}'],
    ("\U0001f600", CHOSEN): ['{"message": "\\ud83d\\ude00"}'],
    ("hello", REPAIRED): [f"Sure: {HELLO}", '{"Message": "hello"}', '{"message": "hello", "reasoning": ["a", 1]}',
        '{"message": ["hello"]}', "{“message”: “hello”, “reasoning”: “r”}",
        '{"message": "hello", // short\n "reasoning": "r"}', '{"message": "hello", "reasoning": "bec',
        '{"to": 3, "output": {"message": "hello", "reasoning": "r"}}',
        '{"output": {"message": "hello"}, "reasoning": "r"}', "**Message:** hello\n**Reasoning:** r"],
    ('say "hi" to \'em', REPAIRED): ["""{'message': 'say "hi" to \\'em', 'reasoning': "it's"}"""],
    (None, UNREADABLE): ["hello", '{"message": 3}', '{"message": ["hello", "there"]}',
        '{"message": "hello" or "bye", "reasoning": "r"}', '{"message": "hello", "bye", "reasoning": "r"}',
        '{"message": "hello the', '{"reasoning": "I tell th', "Message: hello\n\nThis is short.",
        '{"message": "<your message>"}', '{"message": "<brief warning>"}', '{"message": "<>"}', UP, '{"text": "hello"}',
        '{"message": "a", "message": "b"}', '{"message": "a"} {"message": "b"}'],
    ('he said "go, now", to me', REPAIRED): ['{"message": "he said "go, now", to me", "reasoning": "r"}'],
    (None, REPAIRED): ['{"message": "None"}', '{"message": "N/A."}', '{"message": "(no message)"}', "Message: none",
        '{"message": "..."}', '{"message": null, // nobody here\n "reasoning": "r"}'],
    ('Go\u2014"now"', REPAIRED): ['{"message": "Go\\u2014\\"now\\"", "reasoning": "he said "no""}'],
    ("None of us saw it", CHOSEN): ['{"message": "None of us saw it"}'],
    ("<fire near cafe>", CHOSEN): ['{"message":"<fire near cafe>"}'],
}  # fmt: skip


def test_messages_are_read():
    assert misread(MESSAGES, lambda answer: ((said := read_message(answer)).text, said.outcome)) == {}


def test_a_reply_without_text_has_its_own_outcome():
    outcomes = {
        Answer(""): Outcome.EMPTY,
        Answer(" \n", ending="length"): Outcome.TRUNCATED,
        Answer("<think>hm</think>\n"): Outcome.EMPTY,
        Answer("<think>hm", ending="length"): Outcome.TRUNCATED,
        Answer(UP[:20], ending="length"): Outcome.TRUNCATED,
        Answer(UP, ending="aborted"): Outcome.FAILED,
    }
    for answer, outcome in outcomes.items():
        assert read_message(answer).outcome is read_action(answer).outcome is outcome, answer


def test_a_complete_decision_counts_although_the_text_was_cut_and_memory_that_is_no_string_is_json():
    assert read_action(Answer(UP, ending="length")).outcome is CHOSEN
    reading = read_action(Answer('{"action": "stay", "memory": {"seen": ["é"]}, "reasoning": 3}'))
    assert (reading.memory, reading.reasoning, reading.outcome) == ('{"seen": ["é"]}', "3", REPAIRED)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=6,
)
NAMES = st.sampled_from(["action", "Action", "direction", "memory", "reasoning", "message", "other"])
WORDS = st.sampled_from(["up", "north", "stay", "move", "go down", "Left", "east", "up or down", "to the", ""])
PIECES = st.lists(
    st.sampled_from(["<think>", "</think>", "{", "}", '{"action": ', '"up"', "'", '"', ",", ":", "north", UP, DOWN])
    | st.text(max_size=5),
    max_size=12,
).map("".join)  # fmt: skip


@given(st.text() | PIECES | JSON.map(json.dumps) | st.dictionaries(NAMES, WORDS | JSON).map(json.dumps))
@settings(max_examples=40)
def test_any_text_is_read_without_raising_and_no_direction_is_made_up(text):
    said = read_message(Answer(text))
    assert said.text is None or said.outcome in (CHOSEN, REPAIRED)
    done = read_action(Answer(text))
    for kept in (said.text or "", said.reasoning, done.memory, done.reasoning):
        kept.encode()
    if done.direction is not None:
        assert done.action == "move"
        assert re.search(OCCURS[done.direction], text, re.IGNORECASE)


@given(
    choice=st.sampled_from([("stay", None), *(("move", name) for name in OCCURS)]),
    memory=st.text(st.characters(exclude_categories=["Cs"])),
    ascii_only=st.booleans(),
    indent=st.sampled_from([None, 4]),
)
def test_an_action_written_as_json_is_read_back(choice, memory, ascii_only, indent):
    given_reply = {"action": choice[0], "direction": choice[1], "memory": memory, "reasoning": memory}
    reading = read_action(Answer(json.dumps(given_reply, ensure_ascii=ascii_only, indent=indent)))
    assert (reading.action, reading.direction, reading.outcome) == (*choice, CHOSEN)
    assert (reading.memory, reading.reasoning) == (memory, memory)


@given(message=st.text(st.characters(exclude_categories=["Cs"])))
def test_a_python_dict_of_harmless_text_is_read_back(message):
    reading = read_message(Answer(repr({"message": message})))
    assert reading.outcome in (CHOSEN, REPAIRED, UNREADABLE)
    if reading.outcome is not UNREADABLE:
        assert reading.text == read_message(Answer(json.dumps({"message": message}))).text


@pytest.mark.parametrize(
    "text",
    [
        "[" * 30_000,
        '{"a":' * 30_000,
        '{"action": "stay", "memory": ' + "[" * 30_000 + "]" * 30_000 + "}",
        '{"action": "stay", "memory": ' + "[" * 900 + "]" * 900 + "}",
        "{'a':" * 30_000,
        "<think>" * 30_000 + "</think>" * 30_000 + "{",
        '{"action": "move", "direction": ' + "9" * 30_000 + "}",
    ],
    ids=lambda text: text[:12],
)
def test_deep_nesting_is_unreadable(text):
    assert read_action(Answer(text)).outcome is UNREADABLE
    assert read_message(Answer(text)).outcome is UNREADABLE


@pytest.mark.parametrize("unit", ['{"', "<think>", "{", "{'", '{"a"}', '{"action":"stay"', UP + ","])
def test_a_long_text_without_a_decision_is_read_to_its_end(unit):
    text = '{"' + unit * (100_000 // len(unit))
    assert read_action(Answer(text)).outcome is Outcome.UNREADABLE


READ = (Outcome.CHOSEN, Outcome.REPAIRED)


class Labelled(msgspec.Struct, frozen=True, kw_only=True):
    """One reply: the question, its text, what is odd about it, why it ended, what a person reads."""

    question: str
    text: str
    kind: str
    ending: str
    expected: dict[str, Any] | None


def labelled(name: str) -> list[Labelled]:
    lines = (Path(__file__).parent / f"replies_{name}.jsonl").read_bytes().splitlines()
    return [msgspec.json.decode(line, type=Labelled) for line in lines]


def read(labelled: Labelled) -> dict[str, Any] | None:
    answer = Answer(labelled.text, labelled.ending)
    if labelled.question == "message":
        said = read_message(answer)
        return {"message": said.text} if said.outcome in READ else None
    done = read_action(answer)
    return {"action": done.action, "direction": done.direction} if done.outcome in READ else None


@pytest.mark.parametrize(("name", "least"), [("dev", 117), ("held", 117)])
def test_labelled_replies_are_read_as_meant_and_nothing_is_made_up(name: str, least: int):
    wrong = [(labelled, said) for labelled in labelled(name) if (said := read(labelled)) != labelled.expected]
    assert [said for _, said in wrong if said is not None] == []
    assert len(labelled(name)) - len(wrong) >= least, Counter(labelled.kind for labelled, _ in wrong)


def test_the_words_of_a_prompt_in_the_place_of_a_message_are_no_message():
    texts = "".join(path.read_text(encoding="utf-8") for path in (conf_dir() / "prompt").glob("*.yaml"))
    placeholders = re.findall(r'^\s+"message": "(.+)",$', texts, re.MULTILINE)
    assert len(placeholders) >= 5 and all(is_placeholder(placeholder) for placeholder in placeholders)


def test_every_word_means_what_it_stands_for():
    for direction, word in ((direction, word) for direction, words in MEANINGS.items() for word in words):
        said = {"action": word} if direction in (STAY, MOVE) else {"action": "move", "direction": word}
        reading = read_action(Answer(json.dumps({"direction": "up"} | said if direction == MOVE else said)))
        expected = ("stay", None) if direction == STAY else ("move", "up" if direction == MOVE else direction)
        assert (reading.action, reading.direction, reading.outcome in READ) == (*expected, True), word


REPLIES = st.sampled_from(labelled("dev"))
CHANGES = st.sampled_from(
    ['"', "'", "“", "{", "}", "[", "]", ",", ":", "\\", "\n", "//", "/*", "```", "<think>", "</think>", '"action": ',
     "\nDirection: ", "{" * MOST_BRACKETS, "[" * 300, "\x00", "\ud800", " or ", "9" * 5000, "x" * LONGEST]
)  # fmt: skip


@given(REPLIES.filter(lambda labelled: labelled.question == "action" and labelled.expected), REPLIES)
@settings(max_examples=25)
def test_two_decisions_in_one_reply_are_none_unless_they_agree(one, other):
    reading = read_action(Answer(one.text + "\n\n" + other.text))
    if reading.outcome in READ:
        decisions = [each.expected for each in (one, other) if each.question == "action" and each.expected]
        assert {"action": reading.action, "direction": reading.direction} in decisions
