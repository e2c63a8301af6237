"""Edits of what is seen and told in 3D worlds, on questions made by hand."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import edits_of

EDITS = {edit.name: edit for edit in edits_of("camera")}
POSE = {"x": 1.0, "y": 2.0, "z": 0.5, "yaw": 90.0, "pitch": -10.0}
SEEN: dict[str, Any] = {
    **POSE, "step": 1, "task": "Find the lamp.", "target": "lamp", "idle_streak": 2,
    "instruction": {"en": "Pass the door to the lamp.", "ja": "lampへ"},
    "history": ({"step": 0, "reply": "I go to the lamp.", "outcome": "moved", "pose": POSE},),
    "choices": [{"letter": "A", "text": "sofa → lamp"}, {"letter": "B", "text": "lamp → sofa"}],
}  # fmt: skip
PIXELS = np.stack(np.broadcast_arrays(np.arange(72) * 3, np.arange(48)[:, None] * 5, 99), axis=-1).astype(np.uint8)


def encoded(image_format: str) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(PIXELS).save(buffer, image_format)
    return buffer.getvalue()


def decoded(image: bytes, image_format: str) -> Any:
    with Image.open(io.BytesIO(image), formats=[image_format]) as found:
        return np.asarray(found, dtype=float)


def edited(name: str, *images: bytes) -> Question:
    changed = EDITS[name].applied(Question(2, 0, "move", SEEN, images))
    assert changed is not None
    return changed


@pytest.mark.parametrize(
    ("edit", "changes"),
    [
        ("no_history", {"history": (), "idle_streak": 0}),
        ("no_pose", {**dict.fromkeys(POSE), "history": ({**SEEN["history"][0], "pose": None},)}),
        (
            "no_labels",
            {
                "target": "thing 1",
                "task": "Find the thing 1.",
                "instruction": {"en": "Pass the door to the thing 1.", "ja": "thing 1へ"},
                "choices": [{"letter": "A", "text": "thing 2 → thing 1"}, {"letter": "B", "text": "thing 1 → thing 2"}],
            },
        ),
    ],
)
def test_what_is_taken_away_is_gone_wherever_it_was_told_and_nothing_else_is(edit: str, changes: dict[str, Any]):
    assert edited(edit).observation == {**SEEN, **changes}


@pytest.mark.parametrize(("image_format", "off"), [("PNG", 0), ("JPEG", 1)])
@pytest.mark.parametrize(
    ("edit", "change"), [("mirror_image", lambda seen: seen[:, ::-1]), ("blank_image", lambda seen: 0 * seen + 128)]
)
def test_every_image_is_changed_and_stays_as_large_and_of_its_format(
    edit: str, change: Callable[[Any], Any], image_format: str, off: float
):
    """A JPEG that is encoded again is nearly what it was."""
    seen = encoded(image_format), encoded("PNG")
    changed = edited(edit, *seen)
    for before, after, known, most in zip(seen, changed.images, (image_format, "PNG"), (off, 0), strict=True):
        assert np.abs(decoded(after, known) - change(decoded(before, known))).mean() <= most
    assert EDITS[edit].applied(replace(changed, images=())) is None


def test_left_and_right_are_exchanged_in_every_action_that_names_a_side():
    sides = {"left": "right", "turn left": "turn right"}
    both = sides | {other: side for side, other in sides.items()} | {"forward": "forward", "stay": "stay"}
    assert {action: EDITS["mirror_image"].expected(action) for action in both} == both
