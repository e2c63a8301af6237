"""Replies as models of 1 to 8 billion parameters write them, labelled before anything was read of them.

A label is what a person reads: an action and its direction, a message (null: silence), or null where nothing can be
told. The rules were written by others than the labels; `replies_held.jsonl` was not looked at while they were written.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foundry.paths import conf_dir
from foundry.records import Outcome
from foundry.worlds.base import Answer
from foundry.worlds.grid.parsing import read_action, read_message
from foundry.worlds.grid.vocabulary import MEANINGS, MOVE, STAY
from foundry.worlds.grid.words import is_placeholder
from foundry.worlds.mending import LONGEST, MOST_BRACKETS

READ = (Outcome.CHOSEN, Outcome.REPAIRED)


class Labelled(msgspec.Struct, frozen=True, kw_only=True):
    """One reply: the question, its text, what is odd about it, why it ended, what a person reads."""

    question: str
    text: str
    kind: str
    ending: str
    expected: dict[str, Any] | None


def labelled(name: str) -> list[Labelled]:
    """Return a set of labelled replies."""
    lines = (Path(__file__).parent / f"replies_{name}.jsonl").read_bytes().splitlines()
    return [msgspec.json.decode(line, type=Labelled) for line in lines]


def read(one: Labelled) -> dict[str, Any] | None:
    """Return what the reader reads, in the form of a label."""
    answer = Answer(one.text, one.ending)
    if one.question == "message":
        said = read_message(answer)
        return {"message": said.text} if said.outcome in READ else None
    done = read_action(answer)
    return {"action": done.action, "direction": done.direction} if done.outcome in READ else None


@pytest.mark.parametrize(("name", "least"), [("dev", 117), ("held", 117)])
def test_labelled_replies_are_read_as_meant_and_nothing_is_made_up(name: str, least: int):
    wrong = [(one, said) for one in labelled(name) if (said := read(one)) != one.expected]
    assert [said for _, said in wrong if said is not None] == []
    assert len(labelled(name)) - len(wrong) >= least, Counter(one.kind for one, _ in wrong)


def test_the_words_of_a_prompt_in_the_place_of_a_message_are_no_message():
    texts = "".join(path.read_text(encoding="utf-8") for path in (conf_dir() / "prompt").glob("*.yaml"))
    placeholders = re.findall(r'^\s+"message": "(.+)",$', texts, re.MULTILINE)
    assert len(placeholders) >= 5 and all(is_placeholder(one) for one in placeholders)


@pytest.mark.parametrize(("direction", "word"), [(name, word) for name, words in MEANINGS.items() for word in words])
def test_every_word_means_what_it_stands_for(direction: str, word: str):
    said = {"action": word} if direction in (STAY, MOVE) else {"action": "move", "direction": word}
    if direction == MOVE:
        said["direction"] = "up"
    reading = read_action(Answer(json.dumps(said)))
    expected = ("stay", None) if direction == STAY else ("move", "up" if direction == MOVE else direction)
    assert (reading.action, reading.direction, reading.outcome in READ) == (*expected, True)


REPLIES = st.sampled_from(labelled("dev"))
PIECES = st.sampled_from(
    ['"', "'", "“", "{", "}", "[", "]", ",", ":", "\\", "\n", "//", "/*", "```", "<think>", "</think>", '"action": ',
     "\nDirection: ", "{" * MOST_BRACKETS, "[" * 300, "\x00", "\ud800", " or ", "9" * 5000, "x" * LONGEST]
)  # fmt: skip


@given(REPLIES, st.lists(st.tuples(st.integers(0, 400), st.integers(0, 30), PIECES), min_size=1, max_size=4))
@settings(max_examples=150, deadline=None)
def test_a_reply_with_changes_in_it_is_read_without_raising(reply, changes):
    text = reply.text
    for at, dropped, put in changes:
        text = text[:at] + put + text[at + dropped :]
    answer = Answer(text, reply.ending)
    action, message = read_action(answer), read_message(answer)
    assert (action, message) == (read_action(answer), read_message(answer))
    assert action.outcome in READ or (action.action, action.direction, action.memory) == ("stay", None, "")
    assert message.outcome in READ or message.text is None


@given(REPLIES.filter(lambda one: one.question == "action" and one.expected), REPLIES)
@settings(max_examples=100, deadline=None)
def test_two_decisions_in_one_reply_are_none_unless_they_agree(one, other):
    reading = read_action(Answer(one.text + "\n\n" + other.text))
    if reading.outcome in READ:
        decisions = [each.expected for each in (one, other) if each.question == "action" and each.expected]
        assert {"action": reading.action, "direction": reading.direction} in decisions
