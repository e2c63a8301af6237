"""The words that name an action or a direction."""

from __future__ import annotations

import re
from dataclasses import dataclass

_STAYS = frozenset(("stay", "wait", "remain"))
_MOVES = frozenset(("move", "go", "walk"))
_FILLERS = frozenset(("to", "the"))
_DIRECTIONS = {
    word: direction
    for direction, words in {
        "up": ("up", "upward", "upwards", "north"),
        "down": ("down", "downward", "downwards", "south"),
        "left": ("left", "leftward", "leftwards", "west"),
        "right": ("right", "rightward", "rightwards", "east"),
    }.items()
    for word in words
}
_WORD = re.compile(r"[^\W_]+")
_LONGEST = 40
"""Characters; anything longer is a sentence, whose meaning is not guessed."""


@dataclass(frozen=True, slots=True)
class Meaning:
    """An action (`stay` or `move`) and, for a move, its direction."""

    action: str
    direction: str | None


_STAY = Meaning("stay", None)


def understand(action: object, direction: object) -> Meaning | None:
    """Return what the two values of a reply mean together, or None when that is not certain.

    Every word must be known; the direction may stand in either value, but not two different ones.
    """
    words = _words(action)
    if not words or words & _STAYS and words & (_MOVES | _DIRECTIONS.keys()):
        return None
    if words & _STAYS:
        return _STAY
    further = set() if direction in (None, "") else _words(direction)
    if further is None or further & _STAYS:
        return None
    directions = {_DIRECTIONS[word] for word in words | further if word in _DIRECTIONS}
    return Meaning("move", directions.pop()) if len(directions) == 1 else None


def _words(value: object) -> set[str] | None:
    """Return the known words of a value, or None when it holds another, or is no short string."""
    if not isinstance(value, str) or len(value) > _LONGEST:
        return None
    words = set(_WORD.findall(value.lower())) - _FILLERS
    return words if words <= (_STAYS | _MOVES | _DIRECTIONS.keys()) else None
