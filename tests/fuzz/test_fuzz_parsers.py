"""Whatever a model says is read without an error, and read as something that can happen and be kept."""

import math

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from foundry.records import Outcome
from foundry.worlds.base import ABORTED, LENGTH, STOPPED, Answer
from foundry.worlds.camera.language import command_record
from foundry.worlds.camera.language.interpreter import (
    SHIPPED_LIMITS,
    JsonInterpreter,
    LastSentenceInterpreter,
    LatestInterpreter,
)
from foundry.worlds.grid.parsing import read_action, read_message

CHECKS = [HealthCheck.too_slow, HealthCheck.data_too_large]
FUZZ = settings(deadline=None, derandomize=True, database=None, suppress_health_check=CHECKS)
BATCH = 25
"""Replies of an example; at length, 200,000 for the parser and 50,000 for each interpreter."""
GRID_WORDS = (
    "{", "}", "[", "]", ":", ",", '"', "'", "\\", "\n", " ", "```json", "```", "<think>", "</think>", "/", "\\u",
    "\\ud800", '"action"', '"direction"', '"memory"', '"reasoning"', '"message"', "action", "Direction ", '"move"',
    '"stay"', "'up'", '"left"', "null", "None", "true", "NaN", "Infinity", "-1e999", "0" * 400, "9" * 5000, "move",
    "north", "\x00", "\x1b[2J", "\ud800", "\udfff", "\u202e", "é", "日", "{" * 50, "[" * 300,
    '{"action":"move","direction":"up"}', "{'action': 'stay'}",
)  # fmt: skip
SPACE_WORDS = (
    "move", "go", "walk", "turn", "look", "stay", "stop", "forward", "back", "left", "right", "up", "down",
    "around", "not", "don't", "if", "maybe", "then", "I", "will", "1", "0.5", "-3", "1e999", "9" * 400, "½", "two",
    "metres", "m", "cm", "degrees", "°", "steps", ".", ",", "!", "?", "\n", " ", "  ", '"', "(", ")", "{", "}",
    ":", "[", "]", "<think>", "</think>", '{"translate":', '{"turn": 1e400}', '"distance"', '"bearing"', '"gaze"',
    "NaN", "inf", "null", "\x00", "\ud800", "\u202e", "vorwärts", "links", "90 Grad", "avance", "tourne", "前", "右",
    "を", "向", "ます", "moved", "turned", "having", "the robot", "in the last step", "in order to", "later",
    "but first", "no, wait", "->", "step 3:", "I said", "“", "”", "「", "」", "Options:\n- ", "pi/2", "π", "radians",
    "instead", "ました", "ロボットが", "gegangen", "avancé", "走了", '{"action": "turn",', '"angle": 45}',
)  # fmt: skip


def replies(words: tuple[str, ...]) -> st.SearchStrategy[str]:
    joined = st.lists(st.sampled_from(words), max_size=30)
    return st.one_of(
        joined.map("".join),
        joined.map(" ".join),
        st.text(max_size=60),
        st.text(st.sampled_from("{}\"':,\\ "), max_size=60),
    )


GRID = st.lists(replies(GRID_WORDS), min_size=BATCH, max_size=BATCH)
SPACE = st.lists(replies(SPACE_WORDS), min_size=BATCH, max_size=BATCH)


def check_grid(texts: list[str]) -> None:
    for number, text in enumerate(texts):
        answer = Answer(text, (STOPPED, LENGTH, ABORTED)[number % 3])
        action, message = read_action(answer), read_message(answer)
        assert action == read_action(answer) and message == read_message(answer)
        assert (action.action, action.direction) in MOVES
        decided = (Outcome.CHOSEN, Outcome.REPAIRED)
        assert action.outcome in decided or (action.action, action.memory, action.reasoning) == ("stay", "", "")
        assert message.outcome in decided or message.text is None
        for said in (action.memory, action.reasoning, message.text or "", message.reasoning):
            said.encode()


MOVES = {("stay", None), *(("move", direction) for direction in ("up", "down", "left", "right"))}


def check_space(texts: list[str]) -> None:
    for text in texts:
        for interpreter in (LatestInterpreter(), LastSentenceInterpreter(), JsonInterpreter()):
            for limits in (None, SHIPPED_LIMITS):
                command = interpreter.read(text, limits)
                assert command == interpreter.read(text, limits)
                kept = command_record(command)
                numbers = [command.turn, command.gaze, *(kept["translate"] or {}).values()]
                assert all(one is None or math.isfinite(one) for one in numbers), (text, kept)
                assert msgspec.json.decode(msgspec.json.encode(kept)) == kept
                "\n".join(command.notes).encode()
                if limits is not None and command.translate is not None:
                    assert 0 <= command.translate.distance <= limits.max_distance_m


AT_LENGTH = (pytest.mark.exhaustive, pytest.mark.timeout(1800))


@pytest.mark.parametrize("batches", [40, pytest.param(8_000, marks=AT_LENGTH)])
def test_the_parser_of_the_grid_raises_nothing(batches: int):
    settings(FUZZ, max_examples=batches)(given(GRID)(check_grid))()


@pytest.mark.parametrize("batches", [12, pytest.param(2_000, marks=AT_LENGTH)])
def test_the_interpreters_raise_nothing(batches: int):
    settings(FUZZ, max_examples=batches)(given(SPACE)(check_space))()
