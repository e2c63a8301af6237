"""Reads a movement that is given as a JSON object: {"direction": ..., "distance": ..., "turn": ..., "gaze": ...}.

`direction` is one of the words below or null, `distance` metres, `turn` degrees to the left, `gaze` degrees
upwards; missing, null and 0 mean none, and a command without any motion is "stay". Other keys are ignored, unless
they name the action: an object in words of its own, such as {"action": "turn", "direction": "left", "angle": 45}, is
put into a sentence and read as one.
"""

from __future__ import annotations

import re
from typing import Any

from foundry.records import Outcome
from foundry.worlds.camera.language.amounts import LARGEST
from foundry.worlds.camera.language.command import BEARINGS, Command, Limits, Translation, limited
from foundry.worlds.camera.language.json_words import names_action, worded_command
from foundry.worlds.replies import Conflicting, find_objects, whole_object, without_thinking

_KEYS = frozenset(("direction", "distance", "turn", "gaze"))
_BEARINGS = {
    "-".join(sorted((way.value for way in ways), reverse=reverse)): bearing
    for ways, bearing in BEARINGS.items()
    for reverse in (False, True)
}
_NONE = frozenset(("", "none", "stay", "null"))
_FENCE = re.compile(r"\A\s*```\w*|```\s*\Z")


def whole_command(reply: str, limits: Limits) -> Command | None:
    """Return the command that the whole reply is, thinking and code fences aside; None when it is none."""
    found = whole_object(reply)
    if found is not None:
        return _command(found, limits, Outcome.CHOSEN)
    found = whole_object(_FENCE.sub("", without_thinking(reply)))
    return None if found is None else _command(found, limits, Outcome.REPAIRED)


def embedded_command(reply: str, limits: Limits) -> Command | None:
    """Return the command of the last object in the reply that is one, None when there is none."""
    objects = reversed(find_objects(without_thinking(reply)))
    commands = (_command(found, limits, Outcome.REPAIRED) for found in objects)
    return next((command for command in commands if command is not None), None)


def _command(found: dict[str, Any], limits: Limits, outcome: Outcome) -> Command | None:
    if isinstance(found, Conflicting):
        return None
    in_numbers = any(_is_number(found.get(key)) for key in ("turn", "gaze"))
    if in_numbers or not (found.keys() - _KEYS or _is_nested(found)):
        return _numbers(found, limits, outcome)
    worded = worded_command(found, limits, outcome)
    if worded is not None or (names_action(found) and "distance" not in found):
        return worded
    return _numbers(found, limits, outcome)


def _is_nested(found: dict[str, Any]) -> bool:
    return any(isinstance(value, dict) for value in found.values())


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and value != 0


def _numbers(found: dict[str, Any], limits: Limits, outcome: Outcome) -> Command | None:
    """Return the command of an object with the keys that the prompt asks for."""
    if not found.keys() & _KEYS or not _is_sound(found):
        return None
    notes: list[str] = []
    translate = None
    bearing = _BEARINGS.get(_direction(found))
    if bearing is not None and found.get("distance") != 0:
        asked = found.get("distance")
        if asked is None:
            notes.append(f"translate: no amount named, {limits.default_distance_m:g} m by default")
            asked = limits.default_distance_m
        translate = Translation(bearing, limited("translate", asked, limits.max_distance_m, "m", notes))
    turn = limited("turn", found.get("turn") or 0.0, limits.max_turn_deg, "degrees", notes) or None
    gaze = limited("gaze", found.get("gaze") or 0.0, limits.max_gaze_deg, "degrees", notes) or None
    stay = translate is None and turn is None and gaze is None
    return Command(translate, turn, gaze, stay, outcome, ("read as JSON", *notes))


def _is_sound(found: dict[str, Any]) -> bool:
    """Tell whether all values have their types, and a distance its direction."""
    numbers = [found.get(key) for key in ("distance", "turn", "gaze")]
    if not all(value is None or (type(value) in (int, float) and abs(value) <= LARGEST) for value in numbers):
        return False
    direction = _direction(found)
    if direction in _NONE:
        return not found.get("distance")
    return direction in _BEARINGS and (found.get("distance") or 0) >= 0


def _direction(found: dict[str, Any]) -> str:
    """Return the direction in one spelling; what is none is kept, to be refused."""
    value = found.get("direction")
    if value is None:
        return ""
    words = re.findall(r"[a-z]+", value.lower()) if isinstance(value, str) else ["?"]
    return "-".join(words) if len(words) < 3 else "?"
