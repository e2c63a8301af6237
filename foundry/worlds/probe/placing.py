"""A 2D question whose agent perceives all that has a place somewhere else: mirrored, or turned."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

Moving: TypeAlias = Callable[[float, float], tuple[float, float]]
"""Where a point (x, y) comes to be."""
_WAYS = ("up", "down", "left", "right")
_PLACED = ("fires", "places", "neighbours", "seen", "exits", "food", "zones")
"""Keys of lists of things that have a place."""


def placed(
    question: Question, move: Moving, ways: Mapping[str, str], window: Callable[[Sequence[str]], list[str]]
) -> Question:
    """Return the question with every place moved; places in texts, as in messages and memories, stay.

    Args:
        question: of a 2D world.
        move: where a point comes to be; exact, and the origin stays.
        ways: what each direction becomes, where it changes.
        window: what becomes of the rows of text that an agent sees, the uppermost first.
    """
    seen = question.observation
    x, y = move(seen["x"], seen["y"])
    open_ways = {ways.get(way, way) for way in seen.get("open", ())}
    return observing(
        question,
        **{key: [_moved(one, move) for one in seen[key]] for key in _PLACED if key in seen},
        x=x,
        y=y,
        burning=[list(move(*cell)) for cell in seen.get("burning", ())],
        window=window(seen.get("window", ())),
        open=[way for way in _WAYS if way in open_ways],
    )


def _moved(thing: Mapping[str, Any], move: Moving) -> dict[str, Any]:
    """Return a thing elsewhere: its middle, and the ends of its width and height."""
    changed = dict(thing)
    if "x" in thing:
        changed["x"], changed["y"] = move(thing["x"], thing["y"])
    if "x_min" in thing:
        corners = move(thing["x_min"], thing["y_min"]), move(thing["x_max"], thing["y_max"])
        xs, ys = (sorted(ends) for ends in zip(*corners, strict=True))
        changed |= {"x_min": xs[0], "x_max": xs[1], "y_min": ys[0], "y_max": ys[1]}
    return changed
