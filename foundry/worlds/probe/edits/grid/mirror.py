"""Left and right are exchanged in all positions; positions in texts, as in messages and memories, stay."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "mirror"
LEAVES = "equivariance"
_SIDES = {"left": "right", "right": "left"}


def edit(question: Question) -> Question:
    """Return the question as it is seen in a mirror on the vertical axis."""
    seen = question.observation
    lists = {key: [_mirrored(one) for one in seen[key]] for key in ("fires", "places", "neighbours") if key in seen}
    return observing(question, **_mirrored({"x": seen["x"]}), **lists)


def expected(action: Any) -> Any:
    """Return the action on the other side; up, down and staying are what they were."""
    return _SIDES.get(action, action)


def _mirrored(thing: Mapping[str, Any]) -> dict[str, Any]:
    """Return a thing with its place mirrored: x, and the ends of its width."""
    changed = {**thing, "x": -thing["x"]}
    if "x_min" in thing:
        changed |= {"x_min": -thing["x_max"], "x_max": -thing["x_min"]}
    return changed
