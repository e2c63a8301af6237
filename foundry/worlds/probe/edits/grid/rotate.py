"""All positions are turned by a quarter, counter-clockwise; positions in texts, as in messages and memories, stay."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from foundry.worlds.base import Question
from foundry.worlds.probe.placing import placed

NAME = "rotate"
LEAVES = "equivariance"
_TURNED = {"right": "up", "up": "left", "left": "down", "down": "right"}


def edit(question: Question) -> Question:
    """Return the question turned about the middle of the grid."""
    return placed(question, lambda x, y: (0 - y, x), _TURNED, _turned)


def expected(action: Any) -> Any:
    """Return the action in the turned direction; all others are what they were."""
    return _TURNED.get(action, action)


def _turned(rows: Sequence[str]) -> list[str]:
    """Return rows of text turned: what was the last column is the first row."""
    return ["".join(column) for column in zip(*rows, strict=True)][::-1]
