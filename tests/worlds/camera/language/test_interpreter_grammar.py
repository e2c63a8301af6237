"""The closed grammar of English commands: each sentence is read as it says, and its mirror as the mirrored command."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, product

import pytest

from foundry.worlds.camera.language import Command, Translation
from foundry.worlds.camera.language.interpreter import interpret

MOVES = {"move", "go", "step"}
TURNS = {"turn", "rotate"}
GAZES = {"look", "tilt the camera", "turn your head", "rotate your view"}
ALONG = {"forward": 0.0, "back": 180.0, "backward": 180.0}
LEFT, RIGHT = ("left", "to the left"), ("right", "to the right")
UP, DOWN = ("up", "upward", "upwards"), ("down", "downward", "downwards")
ABOUT = ("", "by ", "about ", "for ", "by about ", "approximately ", "around ")
METRES = ("2 meters", "two m", "200 cm")
DEGREES = ("30 degrees", "30°", "thirty deg")
ORDERS = (
    "{verb} {way} {about}{amount}",
    "{verb} {about}{amount} {way}",
    "{verb} {way}, {about}{amount}",
    "I will {verb} {way} {about}{amount}.",
    "Next movement: {verb} {way} {about}{amount}.",
    "{verb} {way} ({about}{amount})",
    "{verb} {way}\n{about}{amount}",
)
NOUNS = ("a {noun} {way} of {amount}", "take a {noun} of {amount} {way}", "Make a {amount} {noun} {way}.")

Motion = tuple[Translation | None, float | None, float | None, bool]


def motion(command: Command) -> Motion:
    """Return what a command moves."""
    return command.translate, command.turn, command.gaze, command.stay


def moved(bearing: float) -> Motion:
    """Return a translation by two metres."""
    return Translation(bearing, 2.0), None, None, False


def turned(degrees: float) -> Motion:
    """Return a turn."""
    return None, degrees, None, False


def gazed(degrees: float) -> Motion:
    """Return a turn of the gaze."""
    return None, None, degrees, False


def worded(verbs: set[str], ways: dict[str, Motion], amounts: tuple[str, ...]) -> Iterator[tuple[str, Motion]]:
    """Yield each sentence with the motion it asks for."""
    for verb, way, about, amount in product(sorted(verbs), ways, ABOUT, amounts):
        for order in ORDERS:
            yield order.format(verb=verb, way=way, about=about, amount=amount), ways[way]


def sentences() -> Iterator[tuple[str, Motion]]:
    """Yield the whole grammar."""
    moves = {way: moved(bearing) for way, bearing in ALONG.items()}
    moves |= dict.fromkeys(LEFT, moved(90.0)) | dict.fromkeys(RIGHT, moved(-90.0))
    turns = dict.fromkeys(LEFT, turned(30.0)) | dict.fromkeys(RIGHT, turned(-30.0))
    gazes = dict.fromkeys(UP, gazed(30.0)) | dict.fromkeys(DOWN, gazed(-30.0))
    yield from worded(MOVES, moves, METRES)
    yield from worded(TURNS, turns, DEGREES)
    yield from worded(GAZES, gazes, DEGREES)
    for noun, order, way, amount in product(("turn", "rotation"), NOUNS, turns, DEGREES):
        yield order.format(noun=noun, way=way, amount=amount), turns[way]
    for way, amount in product(moves, METRES):
        yield f"Take a {amount} step {way}.", moves[way]


@pytest.mark.parametrize("stride", [5, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_every_sentence_of_the_closed_grammar_is_read_as_it_says(stride: int):
    """A stride of 5 takes every verb, way, amount and order, but not all of them with one another."""
    read = {text: (motion(interpret(text)), asked) for text, asked in islice(sentences(), 0, None, stride)}
    misread = {text: found for text, (found, asked) in read.items() if found != asked}
    assert not misread


def test_a_plain_command_and_its_mirror_are_read_as_mirrored_commands():
    mirrors = [("left", "right"), ("up", "down"), ("upward", "downward"), ("clockwise", "counterclockwise")]
    phrases = (
        "turn {}",
        "turn {} around 30 degrees",
        "look {}",
        "look\n{} 20 degrees",
        "move {} 2 m",
        "a turn {}",
        "{}",
    )
    phrases += (
        "tilt {} by 30 degrees",
        "turn {}, then turn {}",
        "do not turn {}",
        "a quarter turn {}",
        "Turn: {}\nAngle: 45",
    )
    for phrase, (way, mirrored_way) in product(phrases, mirrors):
        command, mirrored = (interpret(phrase.replace("{}", word)) for word in (way, mirrored_way))
        assert mirrored.stay == command.stay and mirrored.outcome == command.outcome, (phrase, way)
        assert (mirrored.turn or 0.0, mirrored.gaze or 0.0) == (-(command.turn or 0.0), -(command.gaze or 0.0)), phrase
