"""The interpreter: its limits, its notes, JSON commands, long replies, and the closed grammar of English commands."""

import json
from collections.abc import Iterator
from itertools import islice, product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foundry.errors import InputError
from foundry.records import Outcome
from foundry.worlds.camera.language import Command, Limits, Translation, render_command
from foundry.worlds.camera.language.interpreter import (
    JsonInterpreter,
    LastSentenceInterpreter,
    LatestInterpreter,
    interpret,
)

CHOSEN, REPAIRED, UNREADABLE = Outcome.CHOSEN, Outcome.REPAIRED, Outcome.UNREADABLE
LIMITS = Limits(max_distance_m=3.0, max_turn_deg=90.0, max_gaze_deg=45.0)
INTERPRETERS = [LatestInterpreter(), LastSentenceInterpreter(), JsonInterpreter()]

WORDS = """
move go turn rotate look tilt step take make stay wait forward back left right up down around
clockwise to the a of my and or then but not don't could if I will by at 2 30 1.5 -3 half two
hundred m cm degrees steps feet ° . , ; : ( ) ? \n - * / wall logo is example slightly bit you
said before head gaze moving turned 前に 左に 進む 回転 2メートル 30度 ない 向右转 米 gehe nicht links avanza
derecha pas tourne <think> </think> { } "turn": "direction": null
"""
TALK = st.lists(st.sampled_from([*WORDS.split(), "\n"]) | st.text(max_size=4), max_size=30).map(" ".join)
AMOUNTS = st.floats(1e-6, 1e5) | st.integers(0, 1000).map(float)
ANGLES = AMOUNTS | AMOUNTS.map(lambda value: -value)
BEARINGS = st.sampled_from([0.0, 45.0, 90.0, 135.0, 180.0, -135.0, -90.0, -45.0]) | st.floats(-179, 180).filter(
    lambda bearing: abs(bearing) > 1e-6
)
MOVEMENTS = st.builds(
    Command,
    translate=st.none() | st.builds(Translation, BEARINGS, AMOUNTS),
    turn=st.none() | ANGLES,
    gaze=st.none() | ANGLES,
)

Motion = tuple[Translation | None, float | None, float | None, bool]


def parts(command: Command) -> Motion:
    return (command.translate, command.turn, command.gaze, command.stay)


@pytest.mark.slow
@given(TALK | st.text())
def test_any_text_is_read_within_the_limits_without_raising(text):
    for interpreter in INTERPRETERS:
        command = interpreter.read(text, LIMITS)
        assert command == interpreter.read(text, LIMITS)
        moves = command.translate is not None or command.turn is not None or command.gaze is not None
        assert (command.outcome is UNREADABLE) == (not moves and not command.stay)
        assert not (moves and command.stay)
        assert command.translate is None or 0 <= command.translate.distance <= 3.0
        assert command.translate is None or -180 < command.translate.bearing <= 180
        assert abs(command.turn or 0.0) <= 90.0
        assert abs(command.gaze or 0.0) <= 45.0
        json.dumps(command.notes).encode()
        "".join(command.notes).encode()


@given(MOVEMENTS)
@settings(max_examples=80)
def test_a_command_in_words_is_read_back_as_that_command(command):
    read = interpret(render_command(command))
    assert parts(read) == parts(command)
    assert read.outcome is (UNREADABLE if parts(command) == (None, None, None, False) else CHOSEN)


@given(TALK)
@settings(max_examples=80)
def test_whatever_was_read_is_read_from_its_rendering_again(text):
    command = interpret(text, LIMITS)
    assert parts(interpret(render_command(command), LIMITS)) == parts(command)
    assert parts(LastSentenceInterpreter().read(f"I see it. {render_command(command)}.")) == parts(command)


def test_a_command_is_rendered_in_plain_words_and_staying_is_read_back():
    assert interpret(render_command(Command(stay=True))).stay
    rendered = render_command(Command(Translation(-45.0, 1.5), -30.0, 10.0))
    assert rendered == "move 1.5 m forward-right, turn right 30 degrees, look up 10 degrees"


def test_what_exceeds_a_limit_is_clamped_and_noted():
    command = interpret("Turn right 400 degrees, move back 2 km, look up 1e1 degrees, look down 60 degrees.", LIMITS)
    assert parts(command) == (Translation(180.0, 3.0), -90.0, -45.0, False)
    assert [note for note in command.notes if "clamped" in note] == [
        "translate: 2000 m clamped to 3 m",
        "turn: 400 degrees clamped to 90 degrees",
        "gaze: 60 degrees clamped to 45 degrees",
    ]


@pytest.mark.parametrize(
    ("text", "note"),
    [
        ("move forward", "translate: no amount named, 0.8 m by default"),
        ("turn left", "turn: no amount named, 20 degrees by default"),
        ("look down", "gaze: no amount named, 10 degrees by default"),
        ("turn left a bit", "turn: a small amount, 0.25 of the default of 20 degrees"),
        ("move forward 2 m. move forward 1 m", "translate: the latest of 2"),
        ("I turned left 30 degrees", "told and not asked for: 1"),
        ("move forward 2 m", "translate: 'move forward 2 m'"),
        ("turn 180 degrees", "turn: half a turn: either side leads there"),
        ("move 2 m", "translate: no direction named: read as forward"),
        ("move left 30 degrees", "turn: an angle: read as a turn"),
        ("move forward 2-3 m", "translate: of a range its smaller number"),
        ("move forward for 2 seconds", "translate: '2 seconds' is no distance and no angle"),
        ("do not turn", "named as not to be done: 1"),
        ("hello", "no movement found"),
        ("stay put", "stay: 'stay put'"),
    ],
)
def test_the_notes_say_how_the_text_was_read(text, note):
    limits = Limits(default_distance_m=0.8, default_turn_deg=20.0, default_gaze_deg=10.0, small_factor=0.25)
    assert note in interpret(text, limits).notes


def test_steps_and_a_bit_follow_the_configuration():
    limits = Limits(step_length_m=0.5, small_factor=0.1, default_distance_m=2.0)
    assert interpret("take 3 steps back", limits).translate == Translation(180.0, 1.5)
    assert interpret("move a little to the left", limits).translate == Translation(90.0, 0.2)


def test_what_was_said_before_is_taken_back_by_staying_or_by_a_later_refusal():
    assert parts(interpret("Move forward 2 m. No, stay.")) == (None, None, None, True)
    assert parts(interpret("Move forward 2 m. No, stay. Turn left 5 degrees.")) == (None, 5.0, None, False)
    assert parts(interpret("Turn left 5 degrees and stay there.")) == (None, 5.0, None, False)
    assert parts(interpret("Turn left 5 degrees. No, do not turn left.")) == (None, None, None, False)
    assert parts(interpret("Turn left 5 degrees. I need not turn right.")) == (None, 5.0, None, False)
    assert parts(interpret("<think>Move forward 2 m.</think>")) == (None, None, None, False)
    assert parts(interpret("Move forward 2 m.</think> Turn left 5 degrees.")) == (None, 5.0, None, False)
    assert parts(interpret("<think>Move forward 2 m. Turn left")) == (None, None, None, False)


def test_the_last_sentence_alone_can_be_read():
    turns = {
        "Turn left 30 degrees. Turn right 10 degrees.": -10.0,
        "Turn left 30 degrees.\nI hope this helps!": None,
        "<think>Turn left.</think>\n\n**Turn right 10 degrees.**\n": -10.0,
        "Turn left 30 degrees! :-)": 30.0,
        "The logo is near. Turn left?": None,
        "I see 2.5 m of wall. turn left 30 deg": 30.0,
    } | dict.fromkeys(("", "..."))
    assert {text: LastSentenceInterpreter().read(text).turn for text in turns} == turns


OBJECT = '{"reasoning": "turn left!", "direction": "forward-left", "distance": 1.5, "turn": -30, "gaze": null}'
MOVED = (Translation(45.0, 1.5), -30.0, None, False)


@pytest.mark.parametrize("interpreter", INTERPRETERS)
def test_a_reply_that_is_a_json_command_is_read_as_such_by_all(interpreter):
    assert parts(interpreter.read(OBJECT)) == MOVED
    assert interpreter.read(OBJECT).outcome is CHOSEN
    assert parts(interpreter.read(f"<think>hm</think>```json\n{OBJECT}\n```")) == MOVED
    assert interpreter.read(f"```json\n{OBJECT}\n```").outcome is REPAIRED
    assert parts(interpreter.read(OBJECT, LIMITS)) == MOVED


@pytest.mark.parametrize(
    ("text", "expected", "outcome"),
    [
        (f"Sure! {OBJECT} Good luck.", MOVED, REPAIRED),
        ('{"direction": "Back Right", "distance": 2}', (Translation(-135.0, 2.0), None, None, False), CHOSEN),
        ('{"direction": "left"}', (Translation(90.0, 1.0), None, None, False), CHOSEN),
        ('{"direction": null, "distance": null, "turn": 0, "gaze": 0}', (None, None, None, True), CHOSEN),
        ('{"direction": "none", "turn": 5}', (None, 5.0, None, False), CHOSEN),
        ('{"direction": "forward", "distance": 0, "gaze": 500}', (None, None, 45.0, False), CHOSEN),
        ("move forward 2 m", (Translation(0.0, 2.0), None, None, False), REPAIRED),
        ('{"direction": "north", "distance": 2}', (None, None, None, False), UNREADABLE),
        ('{"direction": null, "distance": 2}', (None, None, None, False), UNREADABLE),
        ('{"direction": "forward", "distance": -2}', (None, None, None, False), UNREADABLE),
        ('{"turn": "left"}', (None, 30.0, None, False), REPAIRED),
        ('{"turn": 5, "turn": 6}', (None, None, None, False), UNREADABLE),
        ('{"turn": true}', (None, None, None, False), UNREADABLE),
        ('{"turn": 1e999}', (None, None, None, False), UNREADABLE),
        ('{"mood": "fine"}', (None, None, None, False), UNREADABLE),
        ('{"action": "turn", "direction": "left", "angle": 45}', (None, 45.0, None, False), CHOSEN),
        ('{"turn": {"direction": "right", "angle_deg": 45}}', (None, -45.0, None, False), CHOSEN),
        ('{"action": "turn", "turn": -30, "direction": null}', (None, -30.0, None, False), CHOSEN),
        ('{"action": "inspect", "direction": "left"}', (None, None, None, False), UNREADABLE),
        ('{"last_action": "turn left 30 degrees", "action": "wait"}', (None, None, None, True), CHOSEN),
        ('{"action": "turn left", "angle": 1' + "0" * 400 + "}", (None, 30.0, None, False), CHOSEN),
    ],
)
def test_json_is_asked_for_and_plain_language_repaired(text, expected, outcome):
    command = JsonInterpreter().read(text, LIMITS)
    assert (parts(command), command.outcome) == (expected, outcome)


def test_a_limit_must_be_above_zero():
    for name, value in {"max_turn_deg": 0.0, "step_length_m": -1.0, "small_factor": float("nan")}.items():
        with pytest.raises(InputError, match=f"limits.{name} is .* Give a number above 0"):
            Limits(**{name: value})


@pytest.mark.parametrize(
    "unit",
    [
        "move forward 2 m. ",
        *(pytest.param(one, marks=pytest.mark.slow) for one in ("a.", "I could turn left or ", "前に進む")),
    ],
)
def test_half_a_megabyte_is_read_to_its_end(unit):
    text = unit * (500_000 // len(unit.encode()))
    assert interpret(f"{text}\nLook up 20 degrees.").gaze == 20.0


@pytest.mark.slow
@pytest.mark.parametrize(("interpreter", "unit"), [(LastSentenceInterpreter(), "a."), (JsonInterpreter(), '{"a": ')])
def test_half_a_megabyte_of_sentences_or_objects_holds_no_movement(interpreter, unit):
    assert interpreter.read(unit * (500_000 // len(unit)), None).outcome is Outcome.UNREADABLE


@pytest.mark.slow
def test_a_sentence_that_is_cut_by_its_length_gives_no_halves():
    assert parts(interpret("I could turn left or " * 30_000)) == (None, None, None, False)
    assert parts(interpret("do not turn left or " * 30_000)) == (None, None, None, False)
    assert interpret("I could turn left or " * 30_000 + "\nLook up 5 degrees").gaze == 5.0


LEFT, RIGHT = ("left", "to the left"), ("right", "to the right")
BEARINGS_OF = {0.0: ("forward",), 180.0: ("back", "backward"), 90.0: LEFT, -90.0: RIGHT}
TURNS_OF = {30.0: LEFT, -30.0: RIGHT}
GAZES_OF = {30.0: ("up", "upward", "upwards"), -30.0: ("down", "downward", "downwards")}
MOVES: dict[str, Motion] = {
    way: (Translation(bearing, 2.0), None, None, False) for bearing, ways in BEARINGS_OF.items() for way in ways
}
TURNS: dict[str, Motion] = {way: (None, turn, None, False) for turn, ways in TURNS_OF.items() for way in ways}
GAZES: dict[str, Motion] = {way: (None, None, gaze, False) for gaze, ways in GAZES_OF.items() for way in ways}
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


def worded(verbs: tuple[str, ...], ways: dict[str, Motion], amounts: tuple[str, ...]) -> Iterator[tuple[str, Motion]]:
    """Yield each sentence with the motion it asks for."""
    for verb, way, about, amount, order in product(verbs, ways, ABOUT, amounts, ORDERS):
        yield order.format(verb=verb, way=way, about=about, amount=amount), ways[way]


def sentences() -> Iterator[tuple[str, Motion]]:
    yield from worded(("move", "go", "step"), MOVES, METRES)
    yield from worded(("turn", "rotate"), TURNS, DEGREES)
    yield from worded(("look", "tilt the camera", "turn your head", "rotate your view"), GAZES, DEGREES)
    for noun, order, way, amount in product(("turn", "rotation"), NOUNS, TURNS, DEGREES):
        yield order.format(noun=noun, way=way, amount=amount), TURNS[way]
    for way, amount in product(MOVES, METRES):
        yield f"Take a {amount} step {way}.", MOVES[way]


@pytest.mark.parametrize("stride", [13, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_every_sentence_of_the_closed_grammar_is_read_as_it_says(stride: int):
    """A stride of 13 takes every verb, way, amount and order, but not all of them with one another."""
    read = {text: (parts(interpret(text)), asked) for text, asked in islice(sentences(), 0, None, stride)}
    misread = {text: found for text, (found, asked) in read.items() if found != asked}
    assert not misread


def test_a_plain_command_and_its_mirror_are_read_as_mirrored_commands():
    mirrors = [("left", "right"), ("up", "down"), ("upward", "downward"), ("clockwise", "counterclockwise")]
    phrases = (
        "turn {}", "turn {} around 30 degrees", "look {}", "look\n{} 20 degrees", "move {} 2 m", "a turn {}", "{}",
        "tilt {} by 30 degrees", "turn {}, then turn {}", "do not turn {}", "a quarter turn {}", "Turn: {}\nAngle: 45",
    )  # fmt: skip
    for phrase, (way, mirrored_way) in product(phrases, mirrors):
        command, mirrored = (interpret(phrase.replace("{}", word)) for word in (way, mirrored_way))
        assert mirrored.stay == command.stay and mirrored.outcome == command.outcome, (phrase, way)
        assert (mirrored.turn or 0.0, mirrored.gaze or 0.0) == (-(command.turn or 0.0), -(command.gaze or 0.0)), phrase
