from __future__ import annotations

import json
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foundry.records import Outcome
from foundry.worlds.base import Answer
from foundry.worlds.grid.parsing import ReadOnce, read_action, read_message

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


@pytest.mark.parametrize(
    ("text", "action", "direction", "outcome"),
    [
        (UP, "move", "up", CHOSEN),
        (f"\n {UP} \n", "move", "up", CHOSEN),
        ('{"action": "stay"}', "stay", None, CHOSEN),
        ('{"action": "stay", "direction": "up", "memory": null}', "stay", None, CHOSEN),
        ('{"action": "stay", "direction": [1], "mood": "fine"}', "stay", None, CHOSEN),
        ('{"action": "stay", "memory": "<think>"}', "stay", None, CHOSEN),
        (f"```json\n{UP}\n```", "move", "up", REPAIRED),
        (f"I go up.\n{UP}\nThat is all.", "move", "up", REPAIRED),
        (f"[{UP}]", "move", "up", REPAIRED),
        (f"<think>down? {DOWN}</think>{UP}", "move", "up", REPAIRED),
        (f"down? {DOWN}</think>{UP}", "move", "up", REPAIRED),
        (f"{UP} {UP}", "move", "up", REPAIRED),
        ("{'action': 'move', 'direction': 'up', 'memory': None, 'ok': True,}", "move", "up", REPAIRED),
        ('{"action": "move", "direction": "up",}', "move", "up", REPAIRED),
        ('{"action": "stay", "memory": "two\nlines"}', "stay", None, REPAIRED),
        ('{"Action": "MOVE", "direction ": " Up "}', "move", "up", REPAIRED),
        ('{"action": "go", "direction": "north"}', "move", "up", REPAIRED),
        ('{"action": "walk", "direction": "leftwards"}', "move", "left", REPAIRED),
        ('{"action": "wait"}', "stay", None, REPAIRED),
        ('{"action": "up"}', "move", "up", REPAIRED),
        ('{"action": "move up", "direction": null}', "move", "up", REPAIRED),
        ('{"action": "move to the right", "direction": "right"}', "move", "right", REPAIRED),
        ('{"action": "move" or "stay"}\nSo: ' + UP, "move", "up", REPAIRED),
        ('\\boxed{x} \\frac{a}{b} ' + UP, "move", "up", REPAIRED),
        ('{"action": ["move"], "direction": ["up"]}', "move", "up", REPAIRED),
        ('{"action": {"type": "move", "direction": "up"}}', "move", "up", REPAIRED),
        ('{"action": "stay", "memory": NaN}', "stay", None, REPAIRED),
        ('{"plan": ' + UP + "}", "move", "up", REPAIRED),
        ('{"step": 3, "decision": {"action": "stay"}}', "stay", None, REPAIRED),
        ('{"action": "move" "direction": "up"}', "move", "up", REPAIRED),
        ('{action: move, direction: up}', "move", "up", REPAIRED),
        ('{"action": "move", // or so\n "direction": "up", # Y+1\n "memory": "m" /* end */}', "move", "up", REPAIRED),
        ('{“action”: “move”, “direction”: “up”, “memory”: “it’s near”}', "move", "up", REPAIRED),
        ('{"action"："move"，"direction"："up"}', "move", "up", REPAIRED),
        ('{\\"action\\": \\"move\\", \\"direction\\": \\"up\\"}', "move", "up", REPAIRED),
        ('{"action": "move", "direction": "up", "memory": "he said "no", twice"}', "move", "up", REPAIRED),
        ("{'action': 'move', 'direction': 'up', 'memory': 'I'm near'}", "move", "up", REPAIRED),
        ('{"action": "move", "direction": "up", "memory": "I am', "move", "up", REPAIRED),
        ('{"action": "stay", "dir', "stay", None, REPAIRED),
        ('{"action": "stay", "direction": ', "stay", None, REPAIRED),
        ('"action": "move",\n"direction": "up"', "move", "up", REPAIRED),
        ("Sure.\n\n**Action:** move\n**Direction:** Up (Y+1)\n\n**Memory:** m", "move", "up", REPAIRED),
        ("- action: stay\n- direction: null", "stay", None, REPAIRED),
        ("**Action:** move\n**Direction:** up\n" + UP, "move", "up", REPAIRED),
        ("Action: move, Direction: up", "move", "up", REPAIRED),
        ("<action>move</action>\n<direction>up</direction>", "move", "up", REPAIRED),
        ('{"action": "remain at current position"}', "stay", None, REPAIRED),
        ('{"action": "do not move", "direction": null}', "stay", None, REPAIRED),
        ('{"action": "move", "direction": "down (Y-1)"}', "move", "down", REPAIRED),
        ('{"action": "move", "direction": "Y + 1"}', "move", "up", REPAIRED),
        ('{"action": "move", "direction": "⬆️"}', "move", "up", REPAIRED),
        ('{"action": "move", "direction": "right, towards the library"}', "move", "right", REPAIRED),
        ('{"行動": "移動", "方向": "上"}', "move", "up", REPAIRED),
        ('{"action": "gehen", "direction": "nach links"}', "move", "left", REPAIRED),
        ('{"action": "move", "direction": "à droite"}', "move", "right", REPAIRED),
        ('{"action": "向上移动"}', "move", "up", REPAIRED),
        ("### Action\nmove\n\n### Direction\nup", "move", "up", REPAIRED),
        ('{"action": "MOVE_RIGHT"}', "move", "right", REPAIRED),
        ('{"action": "move", "direction": "Y = Y - 1"}', "move", "down", REPAIRED),
        ("<thought>{'action': 'stay'}</thought>" + UP, "move", "up", REPAIRED),
        ('{"action": "идти", "direction": "вверх"}', "move", "up", REPAIRED),
    ],
)  # fmt: skip
def test_a_decision_is_read(text, action, direction, outcome):
    reading = read_action(Answer(text))
    assert (reading.action, reading.direction, reading.outcome) == (action, direction, outcome)


@pytest.mark.parametrize(
    "text",
    [
        "move up",
        "{}",
        "[]",
        "null",
        '{"action": "move"}',
        '{"action": "move", "direction": null}',
        '{"action": "move", "direction": "up or down"}',
        '{"action": "move", "direction": "up", "action": "stay"}',
        '{"Action": "move", "action": "stay", "direction": "up"}',
        '{"action": "move up", "direction": "down"}',
        '{"action": "up", "direction": "sideways"}',
        '{"action": "do not move", "direction": "up"}',
        '{"action": "stay or move", "direction": "up"}',
        '{"action": "не up"}',
        '{"direction": "up"}',
        '{"plan": ' + UP + ', "action": st',
        f"{UP} or {DOWN}",
        UP + ' {"action": "fly"}',
        UP * 40,
        '{"action": "move", "direction": "up", "down", "left", or "right", "memory": "m"}',
        '{"action": "move", "direction": "up" "down"}',
        '{"action": "move", "direction": up, down, "memory": "m"}',
        "{'action': 'move', 'direction': 'up', 'down', 'left', 'right', 'memory': 'm'}",
        '{"action": "move", "direction": "up"/"down", "memory": "m"}',
        '{"action": "move", "direction": "up" // or "down"\n}',
        '{"action": "move", "stay", "direction": "up"}',
        '{"action": "move", "direction": "up"\n{"action": "stay"}',
        '{"action": "move", "direction": "up"\n"direction": "down"}',
        '{"action": "move" "direction": "up"} {"action": "stay"}',
        '{"action": "move", "direction": "up',
        '{"action": "move", "direction": up',
        '{"action": "move", "direction": ["up", "left"]}',
        '{"action": "move", "direction": "up (or down)"}',
        '{"action": "move", "direction": "up?"}',
        '{"action": "move", "direction": "right (X-1)"}',
        '{"action": "move", "direction": "northeast"}',
        '{"action": "move", "direction": "左下"}',
        '{"action": "move", "direction": "left of the bar"}',
        '{"action": "move", "direction": "not up"}',
        '{"action": "stay away"}',
        '{"previous_action": ' + UP + "}",
        '{"memory": ' + UP + "}",
        '{"first": ' + UP + ', "second": ' + DOWN + "}",
        "action: move\naction: stay\ndirection: up",
        "action: move or stay\ndirection: up",
        "**Action:** move\n**Direction:** down\n" + UP,
        "Action: <action>",
    ],
)  # fmt: skip
def test_nothing_is_invented(text):
    reading = read_action(Answer(text))
    assert (reading.action, reading.direction, reading.outcome) == ("stay", None, UNREADABLE)
    assert (reading.memory, reading.reasoning) == ("", "")
    assert read_action(Answer(text, ending="length")).outcome is Outcome.TRUNCATED


@pytest.mark.parametrize(
    ("text", "said", "outcome"),
    [
        (HELLO, "hello", CHOSEN),
        ('{"message": "hello"}', "hello", CHOSEN),
        ('{"message": null}', None, CHOSEN),
        ('{"message": " ", "reasoning": "r"}', None, CHOSEN),
        ('{"reasoning": "r"}', None, CHOSEN),
        ('{"message": "{\\"action\\": 1}"}', '{"action": 1}', CHOSEN),
        ('{"message": "\\ud800!", "reasoning": "r"}', "\ufffd!", CHOSEN),
        ('{"message": "\\ud83d\\ude00"}', "\U0001f600", CHOSEN),
        (f"Sure: {HELLO}", "hello", REPAIRED),
        ("""{'message': 'say "hi" to \\'em', 'reasoning': "it's"}""", 'say "hi" to \'em', REPAIRED),
        ('{"Message": "hello"}', "hello", REPAIRED),
        ('{"message": "hello", "reasoning": ["a", 1]}', "hello", REPAIRED),
        ("hello", None, UNREADABLE),
        ('{"message": 3}', None, UNREADABLE),
        ('{"message": ["hello"]}', "hello", REPAIRED),
        ('{"message": ["hello", "there"]}', None, UNREADABLE),
        ('{"message": "he said "go, now", to me", "reasoning": "r"}', 'he said "go, now", to me', REPAIRED),
        ("{“message”: “hello”, “reasoning”: “r”}", "hello", REPAIRED),
        ('{"message": "hello", // short\n "reasoning": "r"}', "hello", REPAIRED),
        ('{"message": "hello", "reasoning": "bec', "hello", REPAIRED),
        ('{"to": 3, "output": {"message": "hello", "reasoning": "r"}}', "hello", REPAIRED),
        ('{"output": {"message": "hello"}, "reasoning": "r"}', "hello", REPAIRED),
        ("**Message:** hello\n**Reasoning:** r", "hello", REPAIRED),
        ('{"message": "None"}', None, REPAIRED),
        ('{"message": "N/A."}', None, REPAIRED),
        ('{"message": "(no message)"}', None, REPAIRED),
        ("Message: none", None, REPAIRED),
        ('{"message": "..."}', None, REPAIRED),
        ('{"message": null, // nobody here\n "reasoning": "r"}', None, REPAIRED),
        ('{"message": "Go\\u2014\\"now\\"", "reasoning": "he said "no""}', 'Go\u2014"now"', REPAIRED),
        ('{"message": "None of us saw it"}', "None of us saw it", CHOSEN),
        ('{"message": "hello" or "bye", "reasoning": "r"}', None, UNREADABLE),
        ('{"message": "hello", "bye", "reasoning": "r"}', None, UNREADABLE),
        ('{"message": "hello the', None, UNREADABLE),
        ('{"reasoning": "I tell th', None, UNREADABLE),
        ("Message: hello\n\nThis is short.", None, UNREADABLE),
        ('{"message": "<your message>"}', None, UNREADABLE),
        ('{"message": "<brief warning>"}', None, UNREADABLE),
        ('{"message": "<>"}', None, UNREADABLE),
        ('{"message":"<fire near cafe>"}', "<fire near cafe>", CHOSEN),
        (UP, None, UNREADABLE),
        ('{"text": "hello"}', None, UNREADABLE),
        ('{"message": "a", "message": "b"}', None, UNREADABLE),
        ('{"message": "a"} {"message": "b"}', None, UNREADABLE),
    ],
)
def test_a_message_is_read(text, said, outcome):
    reading = read_message(Answer(text))
    assert (reading.text, reading.outcome) == (said, outcome)


@pytest.mark.parametrize("read", [read_message, read_action])
@pytest.mark.parametrize(
    ("answer", "outcome"),
    [
        (Answer(""), Outcome.EMPTY),
        (Answer(" \n", ending="length"), Outcome.TRUNCATED),
        (Answer("<think>hm</think>\n"), Outcome.EMPTY),
        (Answer("<think>hm", ending="length"), Outcome.TRUNCATED),
        (Answer(UP[:20], ending="length"), Outcome.TRUNCATED),
        (Answer(UP, ending="aborted"), Outcome.FAILED),
    ],
)
def test_a_reply_without_text_has_its_own_outcome(read, answer, outcome):
    assert read(answer).outcome is outcome


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
@settings(max_examples=200, deadline=None)
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
@settings(deadline=None)
def test_an_action_written_as_json_is_read_back(choice, memory, ascii_only, indent):
    given_reply = {"action": choice[0], "direction": choice[1], "memory": memory, "reasoning": memory}
    reading = read_action(Answer(json.dumps(given_reply, ensure_ascii=ascii_only, indent=indent)))
    assert (reading.action, reading.direction, reading.outcome) == (*choice, CHOSEN)
    assert (reading.memory, reading.reasoning) == (memory, memory)


@given(message=st.text(st.characters(exclude_categories=["Cs"])))
@settings(deadline=None)
def test_a_python_dict_of_harmless_text_is_read_back(message):
    reading = read_message(Answer(repr({"message": message})))
    assert reading.outcome in (CHOSEN, REPAIRED, UNREADABLE)
    if reading.outcome is not UNREADABLE:
        assert reading.text == read_message(Answer(json.dumps({"message": message}))).text


@pytest.mark.parametrize(
    "text",
    [
        "[" * 100_000,
        '{"a":' * 100_000,
        '{"action": "stay", "memory": ' + "[" * 100_000 + "]" * 100_000 + "}",
        '{"action": "stay", "memory": ' + "[" * 900 + "]" * 900 + "}",
        "{'a':" * 100_000,
        "<think>" * 100_000 + "</think>" * 100_000 + "{",
        '{"action": "move", "direction": ' + "9" * 100_000 + "}",
    ],
    ids=lambda text: text[:12],
)
def test_deep_nesting_is_unreadable(text):
    assert read_action(Answer(text)).outcome is UNREADABLE
    assert read_message(Answer(text)).outcome is UNREADABLE


@pytest.mark.parametrize(
    "unit",
    [
        '{"',
        "<think>",
        *(pytest.param(one, marks=pytest.mark.slow) for one in ("{", "{'", '{"a"}', '{"action":"stay"', UP + ",")),
    ],
)
def test_megabytes_without_a_decision_are_read_to_their_end(unit):
    text = '{"' + unit * (1_000_000 // len(unit))
    assert read_action(Answer(text)).outcome is Outcome.UNREADABLE


def test_a_decision_after_ten_megabytes_of_thinking_is_found():
    assert read_action(Answer("<think>" + "hm " * 3_000_000 + "</think>" + UP)).direction == "up"


def test_what_was_read_ahead_of_its_round_is_read_once():
    read: list[str] = []

    def reading(answer: Answer):
        read.append(answer.text)
        return read_message(answer)

    once = ReadOnce(reading)
    assert once.in_round(Answer(HELLO)).text == "hello"
    ahead = [once.ahead(Answer(text)) for text in ("", HELLO)]
    assert [once.in_round(Answer(text)) for text in (HELLO, "")] == ahead[::-1]
    assert read == [HELLO, "", HELLO]
    assert once.in_round(Answer(HELLO)).text == "hello"
