"""What the interpreter reads from replies as vision-language models write them; distances in metres, angles in degrees.

Of the labelled replies, `dev`, `held` and `vlm` were written and labelled before the rule was read; `told` was written
with it, to hold what it does, as was `short`, single phrases that also have the outcome of their reading. `vlm` has 80
replies in the styles of five families of models; some are meant to be unreadable. `held` was never looked at while the
interpreter was written.

A reply is read `exactly` when translation, turn, gaze and staying are those of its label. Any other reading is
`invented` when it moves in a way that the label does not ask for (another kind, direction or amount), else `missed`.
"""

import json
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from foundry.worlds.camera.language import Command, Translation
from foundry.worlds.camera.language.interpreter import interpret

MEASURED = {"dev": (140, 140, 0), "held": (132, 125, 5), "vlm": (80, 79, 0)}
"""The replies, those of them that are read exactly, and those with a motion that nobody asked for."""
_TOLERANCE_M, _TOLERANCE_DEG = 0.01, 0.5


def labelled(half: str) -> list[dict[str, Any]]:
    """Return labelled replies: text, move, turn, gaze, stay; of a half also language and kind."""
    lines = Path(__file__).with_name(f"replies_{half}.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines]


def verdict(label: dict[str, Any], command: Command) -> str:
    move = None if command.translate is None else (command.translate.bearing, command.translate.distance)
    pairs = [(move, label["move"]), (command.turn, label["turn"]), (command.gaze, label["gaze"])]
    same = [_is_same(read, asked) for read, asked in pairs]
    if all(same) and command.stay == label["stay"]:
        return "exactly"
    return (
        "invented" if any(read is not None and not ok for (read, _), ok in zip(pairs, same, strict=True)) else "missed"
    )


def _is_same(read: Any, asked: Any) -> bool:
    if read is None or asked is None:
        return read is asked
    if isinstance(read, tuple):
        return _is_angle(read[0], asked[0]) and math.isclose(read[1], asked[1], abs_tol=_TOLERANCE_M)
    return _is_angle(read, asked)


def _is_angle(read: float, asked: float) -> bool:
    if abs(abs(read) - 180) < _TOLERANCE_DEG:
        read = math.copysign(read, asked)
    return math.isclose(read, asked, abs_tol=_TOLERANCE_DEG)


def test_short_replies_are_read_as_labelled_and_no_movement_is_made_up():
    for label in labelled("short"):
        command = interpret(label["text"])
        asked = None if label["move"] is None else Translation(*label["move"])
        read = (command.translate, command.turn, command.gaze, command.stay, command.outcome)
        assert read == (asked, label["turn"], label["gaze"], label["stay"], label["outcome"]), label["text"]
        assert command.notes, label["text"]


@pytest.mark.parametrize("half", MEASURED)
def test_labelled_replies_are_read_at_least_as_well_as_measured(half):
    replies, exactly, invented = MEASURED[half]
    verdicts = [verdict(reply, interpret(reply["text"])) for reply in labelled(half)]
    assert len(verdicts) == replies
    assert verdicts.count("exactly") >= exactly
    assert verdicts.count("invented") <= invented


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
        "In the last step I {}.", "I {} and was stopped by RackA2.", "I have already {}.", "Having {}, I see a door.",
        "After I {}, nothing changed.", "The robot {} and then {}.", "You first {}, then {}.",
        "前のステップで2メートル前進しましたが、ラックにぶつかりました。", "上一步我向前走了2米。",
    ]
)  # fmt: skip


@given(recaps=st.lists(st.tuples(RECAPS, MOTIONS), max_size=4), command=st.sampled_from(COMMANDS))
def test_no_recap_changes_the_command_that_follows_it(recaps, command):
    text, expected = command
    told = " ".join(recap.format(motion, motion) for recap, motion in recaps)
    assert _moved(interpret(told)) == (None, None, None)
    assert _moved(interpret(f"{told} {text}")) == expected


def _moved(command: Command) -> tuple[object, ...]:
    return (command.translate, command.turn, command.gaze)
