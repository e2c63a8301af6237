"""Left and right are exchanged in all positions; positions in texts, as in messages and memories, stay."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "mirror"
LEAVES = "equivariance"
_SIDES = {"left": "right", "right": "left"}
_WAYS = ("up", "down", "left", "right")
_PLACED = ("fires", "places", "neighbours", "seen", "exits", "food", "zones")
"""Keys of lists of things that have a place."""


def edit(question: Question) -> Question:
    """Return the question as it is seen in a mirror on the vertical axis."""
    seen = question.observation
    placed = {key: [_mirrored(one) for one in seen[key]] for key in _PLACED if key in seen}
    return observing(
        question,
        **placed,
        x=-seen["x"],
        burning=[[-x, y] for x, y in seen.get("burning", ())],
        window=[row[::-1] for row in seen.get("window", ())],
        open=[way for way in _WAYS if expected(way) in seen.get("open", ())],
    )


def expected(action: Any) -> Any:
    """Return the action on the other side; all others are what they were."""
    return _SIDES.get(action, action)


def _mirrored(thing: Mapping[str, Any]) -> dict[str, Any]:
    """Return a thing with its place mirrored: x, and the ends of its width."""
    changed = dict(thing)
    if "x" in thing:
        changed["x"] = -thing["x"]
    if "x_min" in thing:
        changed |= {"x_min": -thing["x_max"], "x_max": -thing["x_min"]}
    return changed
