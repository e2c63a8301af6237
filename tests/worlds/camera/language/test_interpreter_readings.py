"""What the interpreter reads from replies as vision-language models write them."""

from __future__ import annotations

import pytest

from foundry.records import Outcome
from foundry.worlds.camera.language import Translation
from foundry.worlds.camera.language.interpreter import interpret
from reply_readings import GAZES, INFERRED, MOVES, SEVERAL, STAYS, TURNS

NOTHING = [
    "I don't need to turn",
    "the door on my right",
    "the left wall",
    "right now",
    "left behind",
    "in 3 m there is a wall",
    "gate 4",
    'Examples of the movement sentence: "move forward 2 m", "turn right 30 degrees",\n"look up 30 degrees", "stay".',
    "left",
    "right",
    "move sideways 1 m",
    "I'll look around.",
    "look around",
    "look at the logo",
    "Do not turn left or move forward.",
    "Do not move forward and turn left 30 degrees.",
    "Not forward, but left.",
    "It is not necessary to turn left.",
    "I am not sure I should turn left.",
    "Avoid moving forward.",
    "Stay close to the left wall.",
    "stay on course",
    "wait for the next image",
    "I will move to the wall and stop.",
    "Turn right 30 degrees. Actually, do not turn.",
    "approach the logo",
    "get closer to the logo",
    "move toward the logo, 3 m ahead",
    "move forward -2 m",
    "turn to heading 90",
    "turn to 90 degrees",
    "I turned left, then moved forward; the logo is left of the door.",
    "My left hand is on the rail.",
    "There are 3 racks left.",
    "turn onto the left corridor",
    "turn left clockwise",
    "move back to the corridor",
    "face the left wall",
    'step 3: you said "move forward 2 m" -> moved',
    "forward is blocked",
    "left is open",
    "2 m forward is the wall",
    "Forward 2 m to the wall",
    "I don't know what to do.",
    "The answer is 42.",
    "</s>",
    "左を向いています",
    "右の壁に近づく",
    "もし左に進むと壁にぶつかる。",
    "No gires",
    "Perhaps a bit forward.",
    "The image shows a corridor with lamps.",
    "I am not sure what to do here.",
    "¯\\_(ツ)_/¯",
    "Gate 4 is 3 m away.",
    'I see a sign that says "turn left".',
    "There is an arrow pointing to the left.",
    "The camera is looking down at a table.",
    "My heading is 180 degrees, so the left wall is at 270 degrees.",
    "I'm 2 m from the wall.",
    "The logo is about 30 degrees to my left.",
    "The hallway extends forward for about 10 m.",
    "There's a door to the right, 3 m away.",
    "I'll take the door on the right.",
    "The passage to the right leads back to the hall.",
    "Move forward 2 m?",
    "to the left",
    "Walk up to the wall.",
    "Go down the corridor.",
    "The picture on the back wall is right above the left panel.",
    "I left the room and moved on.",
    "Don't move more than 1 m forward.",
    "Never turn left.",
    "I have no reason to move forward.",
    "I refuse to move.",
    "I will neither turn left nor move forward.",
    "Either turn left or turn right.",
    "I might move forward.",
    "Unless I turn left I cannot see it.",
    "Once I move forward 2 m I will be there.",
    "Before moving forward I look up 10 degrees.",
    "look straight ahead",
    "move up 1 m",
    "turn left or right",
    "I can't move forward because a wall blocks me.",
    "The corridor turns left.",
    "Wall: 2 m ahead.",
    "It is 2 m to the left.",
    "Turning left is counter-clockwise. You can look up or down, but not straight up or straight down.",
    "Moving forward 2 m would bring me closer.",
    "Looking up, I see the ceiling.",
    "Turn right now",
    "Turn to face the logo on the right.",
    "Turn towards the left wall.",
    "move to the left of the rack",
    "move right up to the wall",
    "目の前に壁があります。左にドアがあります。",
    "不要向前走",
    "Ich gehe 2 m vorwärts und drehe mich um 30 Grad nach links.",
    "Avanzo 2 metros y giro a la derecha 45 grados.",
    "J'avance de 2 m, puis je tourne à gauche de 30 degrés.",
    "If I have reached the goal, no further movement is needed.",
    "When I get there, the task is completed.",
    "I doubt that the task is complete.",
    "Task complete: false",
    "Previous action:\nTurn left 30 degrees",
]
"""Replies that hold no movement."""
READINGS = [
    *((text, Translation(bearing, distance), None, None, False) for text, bearing, distance in MOVES),
    *((text, None, turn, None, False) for text, turn in TURNS),
    *((text, None, None, gaze, False) for text, gaze in GAZES),
    *((text, Translation(*move) if move else None, turn, gaze, False) for text, move, turn, gaze in SEVERAL),
    *((text, None, None, None, True) for text in STAYS),
]


@pytest.mark.parametrize(("text", "translate", "turn", "gaze", "stay"), READINGS)
def test_a_movement_is_read(text, translate, turn, gaze, stay):
    command = interpret(text)
    assert (command.translate, command.turn, command.gaze, command.stay) == (translate, turn, gaze, stay)
    assert command.outcome is (Outcome.REPAIRED if text in INFERRED else Outcome.CHOSEN)
    assert command.notes


@pytest.mark.parametrize("text", NOTHING)
def test_no_movement_is_made_up(text):
    command = interpret(text)
    assert (command.translate, command.turn, command.gaze, command.stay) == (None, None, None, False)
    assert command.outcome is Outcome.UNREADABLE
    assert command.notes
