"""Reads a movement that is given as a JSON object: {"direction": ..., "distance": ..., "turn": ..., "gaze": ...}.

`direction` is one of the words below or null, `distance` metres, `turn` degrees to the left, `gaze` degrees
upwards; missing, null and 0 mean none, and a command without any motion is "stay". Other keys are ignored, unless
they name the action: an object in words of its own, such as {"action": "turn", "direction": "left", "angle": 45}, is
put into a sentence and read as one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from foundry.records import Outcome
from foundry.worlds.replies import Conflicting, find_objects, whole_object, without_thinking
from foundry.worlds.usd.language.amounts import LARGEST
from foundry.worlds.usd.language.motions import BEARINGS
from foundry.worlds.usd.language.tokens import cleaned
from foundry.worlds.usd.movement import Command, Limits, Translation, limited
from foundry.worlds.usd.resolving import resolve

_KEYS = frozenset(("direction", "distance", "turn", "gaze"))
_BEARINGS = {
    "-".join(sorted((way.value for way in ways), reverse=reverse)): bearing
    for ways, bearing in BEARINGS.items()
    for reverse in (False, True)
}
_NONE = frozenset(("", "none", "stay", "null"))
_ACTIONS = re.compile(
    r"action|command|movement|motion|move|type|verb|turn|rotat|look|gaze|stay|bewegung|aktion|drehung|befehl|"
    r"acci[oó]n|movimiento|comando|giro|mouvement|commande|行動|行动|動作|动作|移動|移动|指令|命令|コマンド|アクション"
)
_DIRECTIONS = re.compile(r"direction|side|^dir$|richtung|direcci[oó]n|方向|向き")
_DISTANCES = re.compile(r"distan|^m$|met(?:er|re)s?|^length|距離|距离|メートル|米|entfernung|strecke|metros")
_ANGLES = re.compile(r"angle|degree|^deg$|winkel|grad|[aá]ngulo|grados|degr[eé]s|角度|度")
_AMOUNTS = re.compile(r"^(?:amount|value|magnitude|quantity|by|units?|parameters?|params|args|arguments)$|量|値|值")
_UNITS = re.compile(r"^units?$|単位|单位|einheit|unidad|unité")
_ELSEWHERE = re.compile(
    r"prev|last|past|history|earlier|result|reason|thought|observ|explan|descri|analysis|goal|task|plan|later|after|"
    r"letzt|vorig|anterior|précéd|grund|razón|raison|前回|履歴|理由|上一|原因"
)
_BARE_WAYS = frozenset(("左", "右", "前", "後ろ", "上", "下"))
_DEEPEST = 3
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
    return _worded(found, limits, outcome) or _numbers(found, limits, outcome)


def _worded(found: dict[str, Any], limits: Limits, outcome: Outcome) -> Command | None:
    """Return the command of an object that names its action in words of its own, None when it does not."""
    words = [*_words(found, 0)]
    named = any(
        _ACTIONS.search(key.lower()) and (isinstance(value, str | dict | list) or key not in _KEYS)
        for key, value in found.items()
    )
    if not named or (found.keys() & _KEYS and not found.keys() - _KEYS and not _is_nested(found)):
        return None
    command = resolve(cleaned(" ".join(words)), limits)
    if command.outcome is Outcome.UNREADABLE:  # Japanese says the action last
        command = resolve(cleaned(" ".join(reversed(words))), limits)
    if command.outcome is Outcome.UNREADABLE:
        return None
    worst = Outcome.REPAIRED if Outcome.REPAIRED in (command.outcome, outcome) else outcome
    return replace(command, outcome=worst, notes=("read as JSON", *command.notes))


def _is_nested(found: dict[str, Any]) -> bool:
    return any(isinstance(value, dict) for value in found.values())


def _words(found: dict[str, Any], depth: int) -> Iterator[str]:
    """Yield what an object says of a movement: the action, then its direction, then how far."""
    ordered: list[tuple[int, str]] = []
    unit = next((str(value) for key, value in found.items() if _UNITS.search(key.lower())), "")
    for key, value in found.items():
        ordered.extend((rank, text) for rank, text in _said(key.lower(), value, unit, depth) if text)
    yield from (text for _, text in sorted(ordered, key=lambda pair: pair[0]))


def _said(key: str, value: Any, unit: str, depth: int) -> Iterator[tuple[int, str]]:
    """Yield the words for one key, each with its place in the sentence."""
    number = f"{value:f}" if isinstance(value, int | float) and not isinstance(value, bool) and value else ""
    if _ELSEWHERE.search(key):
        return
    if isinstance(value, list) and depth < _DEEPEST:
        for item in value:
            yield from _said(key, item, unit, depth + 1)
    elif isinstance(value, dict) and depth < _DEEPEST:
        names = _ACTIONS.search(key) and not _AMOUNTS.search(key)
        yield 0, " ".join((key if names else "", *_words(value, depth + 1)))
    elif _UNITS.search(key):
        return
    elif _ANGLES.search(key):
        yield 2, f"{number} degrees" if number else str(value or "")
    elif _DISTANCES.search(key):
        yield 2, f"{number} m" if number else str(value or "")
    elif _AMOUNTS.search(key):
        yield 2, f"{number} {unit}" if number else str(value or "") if isinstance(value, str) else ""
    elif isinstance(value, str) and _DIRECTIONS.search(key):
        yield 1, f"{value}に" if value in _BARE_WAYS else value
    elif isinstance(value, str) and _ACTIONS.search(key):
        yield 0, value.replace("_", " ")
    elif number and _ACTIONS.search(key):
        yield 0, key
        yield 2, f"{number} {'m' if 'move' in key else 'degrees'}"


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
