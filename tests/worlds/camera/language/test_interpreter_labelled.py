"""Labelled replies: how many are read as labelled, and in how many a motion is read that nobody asked for.

`dev`, `held` and `vlm` were written and labelled before the rule was read; `told` was written with it, to hold what it
does. `vlm` has 80 replies in the styles of five families of models; some are meant to be unreadable.
"""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from foundry.worlds.camera.language.command import Command
from foundry.worlds.camera.language.interpreter import interpret
from worlds.camera.language.reply_shares import by, counted, labelled, verdict

MEASURED = {"dev": (140, 140, 0), "held": (132, 125, 5), "vlm": (80, 79, 0)}
"""The replies, those of them that are read exactly, and those with a motion that nobody asked for."""


@pytest.mark.parametrize("half", MEASURED)
def test_labelled_replies_are_read_at_least_as_well_as_measured(half):
    replies, exactly, invented = MEASURED[half]
    shares = counted(labelled(half))
    assert shares.replies == replies
    assert shares.exactly >= exactly
    assert shares.invented <= invented


def test_no_language_of_the_replies_that_were_worked_on_is_read_worse_than_another():
    assert {language: shares.share for language, shares in by(labelled("dev"), "language").items()} == dict.fromkeys(
        ("en", "ja", "zh"), 1.0
    )


def test_what_is_told_put_off_or_meant_for_others_is_no_command():
    misread = [reply["text"] for reply in labelled("told") if verdict(reply, interpret(reply["text"])) != "exactly"]
    assert misread == []


COMMANDS = [
    ("Turn left 30 degrees.", (None, 30.0, None)),
    ("My next movement: look down 20 degrees.", (None, None, -20.0)),
    ("I will turn right 45 degrees.", (None, -45.0, None)),
    ("右に30度回転します。", (None, -30.0, None)),
    ("现在向右转45度。", (None, -45.0, None)),
]
MOTIONS = st.sampled_from(["moved forward 2 m", "turned right 60 degrees", "looked up 10 degrees", "walked back 1 m"])
RECAPS = st.sampled_from(
    [
        "In the last step I {}.",
        "I {} and was stopped by RackA2.",
        "I have already {}.",
        "Having {}, I see a door.",
        "After I {}, nothing changed.",
        "The robot {} and then {}.",
        "You first {}, then {}.",
        "前のステップで2メートル前進しましたが、ラックにぶつかりました。",
        "上一步我向前走了2米。",
    ]
)


@given(recaps=st.lists(st.tuples(RECAPS, MOTIONS), max_size=4), command=st.sampled_from(COMMANDS))
def test_no_recap_changes_the_command_that_follows_it(recaps, command):
    text, expected = command
    told = " ".join(recap.format(motion, motion) for recap, motion in recaps)
    assert _moved(interpret(told)) == (None, None, None)
    assert _moved(interpret(f"{told} {text}")) == expected


def _moved(command: Command) -> tuple[object, ...]:
    return (command.translate, command.turn, command.gaze)
