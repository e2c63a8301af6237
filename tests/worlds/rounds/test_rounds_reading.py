"""Reading of decisions in worlds of rounds: what is asked for, what is found, and above all what is not invented."""

import json
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from foundry.declared import Actions
from foundry.records import Outcome
from foundry.worlds.base import ABORTED, LENGTH, Answer
from foundry.worlds.rounds.reading import Reading, deciding, idle_of, options_of, read_decision, read_talk

BAR = Actions(labels=("go", "stay"), idle="stay")
CATCH = Actions(low=0, high=100, idle=0)
PRICE = Actions(low=0, high=2.5, whole=False)
SETS = [BAR, CATCH, PRICE, Actions(labels=("do nothing", "punish", "do not punish", "行く")), Actions(low=-3, high=9)]


def bar(text: str, ending: str = "stop") -> tuple[Any, str]:
    reading = read_decision(Answer(text, ending), BAR, "evening")
    return reading.action, str(reading.outcome)


def catch(text: str) -> tuple[Any, str]:
    reading = read_decision(Answer(text), CATCH, "catch")
    return reading.action, str(reading.outcome)


CHOSEN = [
    '{"action": "go"}',
    ' {"action": "go", "reasoning": "I will not stay."}\n',
    '{"evening": "go"}',
    "go",
    " go\n",
]
REPAIRED = [
    'Sure!\n```json\n{"action": "go"}\n```', '<think>{"action": "stay"}</think>{"action": "go"}', "{'action': 'go'}",
    '{action: go, reasoning: "it was empty"}', '{"Action": "GO"}', '{"action": ["go"]}',
    '{"action": "go"} {"action": "go"}', '{"decision": {"action": "go"}, "previous": {"action": "stay"}}', "Action: go",
    "**Decision:** go.", "My decision:\n\n**go**", "<action>go</action>", "I will go.", "I have decided to go!",
    "It was crowded last week, so most will stay. I choose to go.", "Go.\n\nBecause it will be fun.",
    r"Final answer: \boxed{go}",
]  # fmt: skip
IN_DOUBT = [
    "I will not go", "I will not go.", "I will not\ngo", "I won't go.", "I would go.", "I have to go", "Should I go?",
    "go or stay", "go\nstay", "I will go. I will stay.", "Everyone else will go.", "行く", "Options:\n1. go",
    "Go! That is what they all say. I don't.", "What I will not do:\ngo", "Go. Because all who stay are sad.",
    "Go. Because it is fun, or so they say.", '{"action": "not go"}', '{"action": null}',
    '{"action": true}', '{"action": "fly"}', '{"action": "go", "action": "stay"}', '{"action": "go or stay"}',
    '{"action": "go", "decision": "stay"}', '{"action": "go"} {"action": "stay"}', 'Action: stay\n{"action": "go"}',
    '{"reasoning": "I will go"}',
    '{"options": {"action": "go"}}', '{"action": "go" or "stay"}',
]  # fmt: skip


def test_what_is_asked_for_is_chosen_in_another_dress_repaired_and_in_doubt_unreadable():
    assert {text: bar(text) for text in CHOSEN} == dict.fromkeys(CHOSEN, ("go", "chosen"))
    assert {text: bar(text) for text in REPAIRED} == dict.fromkeys(REPAIRED, ("go", "repaired"))
    assert {text: bar(text) for text in IN_DOUBT} == dict.fromkeys(IN_DOUBT, (None, "unreadable"))


@pytest.mark.parametrize(("text", "ending", "outcome"), [
    ("", "stop", "empty"), (" \n", "stop", "empty"), ("", LENGTH, "truncated"), ("go", ABORTED, "failed"),
    ("<think>go</think>", "stop", "empty"), ("go", LENGTH, "truncated"), ("I will go", LENGTH, "truncated"),
    ('{"action": "go', LENGTH, "truncated"),
])  # fmt: skip
def test_a_reply_that_says_nothing_or_was_cut_decides_nothing(text: str, ending: str, outcome: str):
    assert bar(text, ending) == (None, outcome)


def test_a_cut_reply_counts_where_its_decision_is_whole_and_cut_talk_says_nothing():
    assert bar('{"action": "go", "reasoning": "beca', LENGTH) == ("go", "repaired")
    assert read_talk(Answer("Let us take", LENGTH)) == Reading(Outcome.TRUNCATED)


@pytest.mark.parametrize(("text", "action", "outcome"), [
    ('{"action": 10}', 10, "chosen"), ('{"catch": 7.0}', 7, "chosen"), ("10", 10, "chosen"),
    ('{"action": "10 tons"}', 10, "repaired"), ("Catch: 12", 12, "repaired"), ("I catch 10 tons.", 10, "repaired"),
    ("$5", 5, "repaired"), ('{"action": "0"}', 0, "repaired"),
])  # fmt: skip
def test_a_number_of_the_range_is_read(text: str, action: int, outcome: str):
    assert catch(text) == (action, outcome)


@pytest.mark.parametrize("text", [
    '{"action": 101}', '{"action": -1}', '{"action": 2.5}', '{"action": true}', '{"action": NaN}', '{"action": 1e400}',
    "I will not catch 10", "5 tons.\nBecause 10 are too many.", "5-10", "10 of 20", "10%", "1,000", "at most 10",
    "10 or 12", "1e1", "ten",
])  # fmt: skip
def test_what_is_no_number_of_the_range_is_unreadable(text: str):
    assert catch(text) == (None, "unreadable")


def test_the_longer_of_two_labels_is_meant():
    for labels, text in ((SETS[3].labels, "do not punish"), (("go", "go home"), "go home")):
        assert read_decision(Answer(f"I {text}."), Actions(labels=labels), "react").action == text


@pytest.mark.parametrize("actions", SETS)
def test_every_option_and_the_idle_reply_are_chosen(actions: Actions):
    known = options_of(actions)
    idle = idle_of(actions)
    readings = [read_decision(Answer(text), actions, "kind") for text in (*known, *filter(None, [idle]))]
    assert {reading.outcome for reading in readings} == {Outcome.CHOSEN} and len(
        {reading.action for reading in readings}
    ) == len(known)
    assert idle is None or readings[-1].action == actions.idle
    if actions.labels:
        assert [reading.action for reading in readings[: len(known)]] == list(actions.labels)


def test_a_long_range_has_some_options_and_an_endless_one_none():
    assert len(options_of(Actions(low=0, high=10**6))) == 101
    assert options_of(Actions(low=0)) == ()


@pytest.mark.parametrize(("text", "message", "outcome"), [
    ('{"message": "hi"}', "hi", "chosen"), ("Let us take 10.", "Let us take 10.", "chosen"),
    ('{"message": null}', None, "chosen"), ("(silence)", None, "chosen"), ("", None, "empty"),
    ("<think>hm</think>Hello", "Hello", "repaired"), ("Message: hi", "hi", "repaired"),
    ("{broken", None, "unreadable"), ("<your message>", None, "unreadable"),
])  # fmt: skip
def test_talk_is_an_object_with_a_message_or_a_text_without_any(text: str, message: str | None, outcome: str):
    reading = read_talk(Answer(text))
    assert (reading.message, str(reading.outcome)) == (message, outcome)


@given(st.sampled_from(SETS), st.text(max_size=300))
@example(BAR, '{"action": {"action": "go"}}')
@example(CATCH, '{"action": "' + "9" * 110 + '"}')
def test_any_text_is_read_as_a_legal_decision_or_as_none(actions: Actions, text: str):
    reading = read_decision(Answer(text), actions, "kind")
    decided = reading.outcome in (Outcome.CHOSEN, Outcome.REPAIRED)
    assert decided == (reading.action is not None)
    if decided:
        assert deciding(reading.action) in options_of(actions) or not actions.labels


DENIALS = (
    "I will not",
    "Nobody should",
    "If it were empty I would",
    "They say",
    "Do not",
    "I doubt that I",
    "Never",
    "no",
)


@given(
    st.sampled_from(DENIALS),
    st.sampled_from([" ", "\n", "\n\n", ": ", ":\n", ", ", " - ", " **"]),
    st.sampled_from(BAR.labels),
)
def test_words_that_may_take_a_decision_back_leave_none(denial: str, between: str, label: str):
    back = f"{denial}{between}{label}"
    for text in (back, f"I looked around. {back}.", f"{label.capitalize()}. {denial}."):
        assert bar(text) == bar(json.dumps({"action": text})) == (None, "unreadable")


@given(st.sampled_from(BAR.labels), st.text("xyzqv", min_size=1, max_size=9), st.sampled_from([" ", ", ", " (", "\n"]))
def test_a_value_with_an_unknown_word_in_it_decides_nothing(label: str, unknown: str, between: str):
    for text in (f"{unknown}{between}{label}", f"{label}{between}{unknown}"):
        assert bar(json.dumps({"action": text})) == (None, "unreadable")
        assert bar(f"Action: {text.replace(chr(10), ' ')}") == (None, "unreadable")


@pytest.mark.slow
@pytest.mark.parametrize(
    "text", ["{" * 200_000, '{"action": ' * 20_000, "go " * 70_000, "Action: go\n" * 20_000, "go.\n" * 50_000]
)
def test_two_hundred_thousand_characters_are_read_which_quadratic_time_would_not_allow(text: str):
    assert bar(text)[1] in ("unreadable", "repaired", "empty")
