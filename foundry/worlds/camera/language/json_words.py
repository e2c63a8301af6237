"""Reads a JSON object that says a movement in its own words: {"action": "turn", "direction": "left", "angle": 45}."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from foundry.records import Outcome
from foundry.worlds.camera.language.amounts import LARGEST
from foundry.worlds.camera.language.command import Command, Limits
from foundry.worlds.camera.language.resolving import resolve
from foundry.worlds.camera.language.tokens import cleaned

_ACTIONS = re.compile(
    r"action|command|movement|motion|move|type|verb|turn|rotat|look|gaze|stay|"
    r"行動|行动|動作|动作|移動|移动|指令|命令|コマンド|アクション"
)
_DIRECTIONS = re.compile(r"direction|side|^dir$|方向|向き")
_DISTANCES = re.compile(r"distan|^m$|met(?:er|re)s?|^length|距離|距离|メートル|米")
_ANGLES = re.compile(r"angle|degree|^deg$|角度|度")
_AMOUNTS = re.compile(r"^(?:amount|value|magnitude|quantity|by|parameters?|params|args|arguments)$|量|値|值")
_UNITS = re.compile(r"^units?$|単位|单位")
_ELSEWHERE = re.compile(
    r"prev|last|past|history|earlier|result|reason|thought|observ|explan|descri|analysis|goal|task|plan|later|after|"
    r"前回|履歴|理由|上一|原因"
)
_BARE_WAYS = frozenset(("左", "右", "前", "後ろ", "上", "下"))
_DEEPEST = 3
_ACTION, _DIRECTION, _AMOUNT = range(3)
"""Places in the sentence that is made."""


def worded_command(found: dict[str, Any], limits: Limits, outcome: Outcome) -> Command | None:
    """Return the command of an object that names its action, put into a sentence; None when it does not."""
    if not any(_names(key.lower()) for key in found):
        return None
    words = [*_words(found, 0)]
    command = resolve(cleaned(" ".join(words)), limits)
    if command.outcome is Outcome.UNREADABLE:  # Japanese says the action last
        command = resolve(cleaned(" ".join(reversed(words))), limits)
    if command.outcome is Outcome.UNREADABLE:
        return None
    worst = Outcome.REPAIRED if Outcome.REPAIRED in (command.outcome, outcome) else outcome
    return replace(command, outcome=worst, notes=("read as JSON", *command.notes))


def names_action(found: dict[str, Any]) -> bool:
    """Tell whether an object says in a word which kind of action it is."""
    return any(isinstance(found.get(key), str) for key in ("action", "command", "type"))


def _names(key: str) -> bool:
    return bool(_ACTIONS.search(key)) and not _ELSEWHERE.search(key)


def _words(found: dict[str, Any], depth: int) -> Iterator[str]:
    """Yield what an object says of a movement: the action, then its direction, then how far."""
    unit = next((str(value) for key, value in found.items() if _UNITS.search(key.lower())), "")
    said = [part for key, value in found.items() for part in _said(key.lower(), value, unit, depth)]
    yield from (text for _, text in sorted(said, key=lambda part: part[0]) if text)


def _said(key: str, value: Any, unit: str, depth: int) -> Iterator[tuple[int, str]]:
    """Yield the words for one key, each with its place in the sentence."""
    if _ELSEWHERE.search(key) or _UNITS.search(key):
        return
    if isinstance(value, dict | list):
        yield from _nested(key, value, unit, depth)
        return
    number = _number(value)
    measured = _measured(key, unit)
    if measured is not None:
        yield _AMOUNT, f"{number} {measured}" if number else value if isinstance(value, str) else ""
    elif isinstance(value, str) and _DIRECTIONS.search(key):
        yield _DIRECTION, f"{value}に" if value in _BARE_WAYS else value
    elif isinstance(value, str) and _ACTIONS.search(key):
        yield _ACTION, value.replace("_", " ")
    elif number and _ACTIONS.search(key):
        yield _ACTION, key
        yield _AMOUNT, f"{number} {'m' if 'move' in key else 'degrees'}"


def _nested(key: str, value: dict[str, Any] | list[Any], unit: str, depth: int) -> Iterator[tuple[int, str]]:
    if depth >= _DEEPEST:
        return
    if isinstance(value, list):
        for item in value:
            yield from _said(key, item, unit, depth + 1)
    else:
        names = _ACTIONS.search(key) and not _AMOUNTS.search(key)
        yield _ACTION, " ".join((key if names else "", *_words(value, depth + 1)))


def _measured(key: str, unit: str) -> str | None:
    """Return the unit in which the number of a key is given, None when the key names no amount."""
    if _ANGLES.search(key):
        return "degrees"
    if _DISTANCES.search(key):
        return "m"
    return unit if _AMOUNTS.search(key) else None


def _number(value: Any) -> str:
    """Return the digits of a number that can be one, else ""."""
    return f"{value:f}" if type(value) in (int, float) and value and abs(value) <= LARGEST else ""
