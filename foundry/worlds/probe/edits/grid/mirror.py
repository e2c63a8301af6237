"""Left and right are exchanged in all positions; positions in texts, as in messages and memories, stay."""

from __future__ import annotations

from typing import Any

from foundry.worlds.base import Question
from foundry.worlds.probe.placing import placed

NAME = "mirror"
LEAVES = "equivariance"
_SIDES = {"left": "right", "right": "left"}


def edit(question: Question) -> Question:
    """Return the question as it is seen in a mirror on the vertical axis."""
    return placed(question, lambda x, y: (0 - x, y), _SIDES, lambda rows: [row[::-1] for row in rows])


def expected(action: Any) -> Any:
    """Return the action on the other side; all others are what they were."""
    return _SIDES.get(action, action)
