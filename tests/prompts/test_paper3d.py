"""What every 3D prompt variant must hold, and the paper's own to the letter."""

import re
from collections.abc import Mapping
from functools import cache
from typing import Any, cast

import pytest
import yaml

from foundry.paths import conf_dir
from foundry.prompts.prompt import Prompt
from foundry.running.build import build
from foundry.worlds.base import Question
from foundry.worlds.camera.language.interpreter import JsonInterpreter, interpret

VARIANTS = sorted(
    path.stem
    for path in (conf_dir() / "prompt").glob("*.yaml")
    if "\n  move:" in (text := path.read_text("utf-8")) and "{{ task" in text
)
"""Those that any 3D world can be asked by: they need its task and nothing of its own."""
KIBO = yaml.safe_load((conf_dir() / "world" / "kibo.yaml").read_text("utf-8"))

STEP_0 = {
    "task": KIBO["task"],
    "x": 4.0,
    "y": 20.1,
    "z": -0.2358,
    "yaw": 180.0,
    "pitch": 0.0,
    "step": 0,
    "history": (),
    "idle_streak": 0,
    "target": "JAXA logo",
    "limits": {"max_distance_m": 3.0, "max_turn_deg": 180.0, "max_gaze_deg": 60.0},
}

EXAMPLE = """\
You are an agent standing inside the Japanese Experiment Module "Kibo" of the ISS.
The image is your own first-person view.
Task: Find JAXA logo and get close to it.
Briefly say what you see and why you are moving, then state your next single
movement in one sentence, LAST.
Examples of the movement sentence: "move forward 2 m", "turn right 30 degrees",
"look up 30 degrees", "stay".

Movement conventions: distances are in metres unless you name another unit; angles are in degrees. \
Turning left is counter-clockwise. You can look up or down, but not straight up or straight down.

Your current pose: position (4.00, 20.10) m, heading 180 deg, gaze +0 deg.

What is your next single movement?"""

LONG = "I see\n\n  racks.\t" + "x" * 200
LATER = STEP_0 | {
    "x": -0.001,
    "y": 19.956,
    "yaw": 359.7,
    "pitch": -10.4,
    "step": 3,
    "idle_streak": 2,
    "history": (
        {
            "step": 1,
            "reply": "I see a hatch.\nMove forward 2 m.",
            "outcome": "move 2 m forward",
            "pose": {"x": 2.0, "y": 20.1, "z": -0.2, "yaw": 180.0, "pitch": 0.0},
        },
        {
            "step": 2,
            "reply": LONG,
            "outcome": "unreadable",
            "pose": {"x": 2.0, "y": 20.1, "z": -0.2, "yaw": -90.0, "pitch": 12.5},
        },
    ),
}

HISTORY = f"""
Your current pose: position (0.00, 19.96) m, heading 0 deg, gaze -10 deg.

What you did recently:
- step 1: you said "I see a hatch. Move forward 2 m." -> move 2 m forward. \
You were then at (2.00, 20.10) m, heading 180 deg, gaze +0 deg.
- step 2: you said "I see racks. {"x" * 147}" -> unreadable. \
You were then at (2.00, 20.10) m, heading 270 deg, gaze +12 deg.

What is your next single movement?"""

NUDGE = "\n\nYou have not moved for several steps. Try something different.\n\nWhat is your next single movement?"


@cache
def load(name: str) -> Prompt:
    return cast(Prompt, build(yaml.safe_load((conf_dir() / "prompt" / f"{name}.yaml").read_text("utf-8"))))


def render(name: str, observation: Mapping[str, Any]) -> str:
    (message,) = load(name).render(Question(1, 0, "move", observation))
    return message.content


def test_the_prompt_and_the_history_of_the_paper_are_reproduced_to_the_letter_with_the_task_of_kibo():
    assert render("paper3d", STEP_0) == EXAMPLE
    assert render("paper3d", LATER).endswith(HISTORY)


@pytest.mark.parametrize("streak", [0, 2, 3, 9])
def test_the_nudge_comes_after_three_idle_decisions(streak: int):
    assert render("paper3d", LATER | {"idle_streak": streak}).endswith(NUDGE) is (streak >= 3)


def test_quotes_and_code_in_a_reply_are_kept_as_they_are():
    reply = 'He said "{{ 7 * 7 }}" {% if %}'
    entry = LATER["history"][0] | {"reply": reply}
    assert f'you said "{reply}" ->' in render("paper3d", LATER | {"history": (entry,)})


@pytest.mark.parametrize("name", VARIANTS)
def test_every_variant_is_without_ragged_blank_lines_and_moves_nothing_when_it_is_repeated(name: str):
    for observation in (STEP_0, LATER, LATER | {"idle_streak": 3}, STEP_0 | {"task": "  One line.\n\n"}):
        text = render(name, observation)
        assert text == text.strip()
        assert "\n\n\n" not in text
    bare = LATER | {"history": ()}
    for observation in (STEP_0, bare, bare | {"idle_streak": 3}):
        text = render(name, observation)
        for command in (interpret(text), JsonInterpreter().read(text)):
            assert command.idle, (command, text)


HIDDEN = {
    "paper3d": set(),
    "json": set(),
    "japanese": set(),
    "no_history": {"701", "702", "703.00", "704.00", "215", "+16", "R1", "O1"},
    "no_pose": {"703.00", "704.00", "215", "+16", "705.00", "706.00", "217", "-18"},
}


@pytest.mark.parametrize("name", VARIANTS)
def test_every_variant_shows_what_it_should_and_nothing_else(name: str):
    pose = {"x": 703, "y": 704, "z": 791, "yaw": 215, "pitch": 16}
    seen = {"x": 705, "y": 706, "z": 792, "yaw": 217, "pitch": -18, "step": 793, "idle_streak": 3, "task": "T1"}
    history = [{"step": step, "reply": "R1", "outcome": "O1", "pose": pose} for step in (701, 702)]
    secret = {"way": [[794, 795]], "near": 796, "reached": 797, "target_yaw": 798.5, "target_pitch": 799.5}
    text = render(name, STEP_0 | seen | secret | {"history": history})
    shown = set(re.findall(r"[+-]?\d{2,}(?:\.\d+)?|[A-Z]\d", text)) - {"30"}
    expected = {"701", "702", "703.00", "704.00", "215", "+16", "705.00", "706.00", "217", "-18", "R1", "O1", "T1"}
    assert shown == expected - HIDDEN[name]


def test_the_nudge_belongs_to_the_memory():
    assert "several steps" not in render("no_history", LATER | {"idle_streak": 5})
    assert "several steps" in render("no_pose", LATER | {"idle_streak": 5})


def test_the_examples_of_the_japanese_prompt_are_understood():
    shown = re.findall(r"「(.*?)」", render("japanese", STEP_0))
    read = [interpret(sentence) for sentence in shown]
    assert [(command.translate is not None, command.turn, command.gaze, command.stay) for command in read] == [
        (True, None, None, False),
        (False, -30.0, None, False),
        (False, None, 30.0, False),
        (False, None, None, True),
    ]
