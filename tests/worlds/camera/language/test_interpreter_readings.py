"""What the interpreter reads from replies as vision-language models write them."""

from __future__ import annotations

import pytest

from foundry.records import Outcome
from foundry.worlds.camera.language.command import Translation
from foundry.worlds.camera.language.interpreter import interpret
from reply_readings import GAZES, INFERRED, MOVES, SEVERAL, STAYS, TURNS
from reply_refusals import NOTHING

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
