"""What agents can do beyond moving: gather, share, attack, reproduce; how replies ask for it, and are read."""

from __future__ import annotations

import json
import re
from collections.abc import Collection
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from foundry.records import Outcome
from foundry.worlds.base import Answer
from foundry.worlds.grid.parsing import ActionReading, fields_of, interpret_action, read_as, text_of
from foundry.worlds.grid.parts.parts_settings import ATTACK, DEEDS, GATHER, REPRODUCE, SHARE
from foundry.worlds.replies import Conflicting

AIMED = (SHARE, ATTACK)
"""Deeds that are done to another agent."""

_WORDS = {
    GATHER: ("gather", "collect", "harvest", "eat", "forage", "pick", "pick up", "採集", "集める", "採る", "食べる"),
    SHARE: ("share", "give", "donate", "transfer", "分ける", "分け与える", "与える", "渡す", "共有"),
    ATTACK: ("attack", "fight", "rob", "steal", "hit", "攻撃", "攻撃する", "奪う"),
    REPRODUCE: ("reproduce", "breed", "replicate", "繁殖", "繁殖する", "子を作る", "産む"),
}
_MEANT = {word: deed for deed, words in _WORDS.items() for word in words}
_NUMBER = re.compile(r"(?:(?:to|with)\s+)?(?:agent|エージェント)?\s*#?\s*(\d{1,6})", re.IGNORECASE)
_TARGETS = ("target", "agent", "to", "recipient", "victim", "target_agent", "target_id")
_AMOUNTS = ("amount", "energy", "units", "quantity")


@dataclass(frozen=True, slots=True)
class Deed(ActionReading):
    """What a reply to the action question says where agents can do more than move.

    Attributes:
        target: id of the agent that it is done to, for those that are; else None.
        amount: what is shared, or None.
    """

    target: int | None = None
    amount: int | None = None

    @property
    def decision(self) -> tuple[object, ...]:
        """What several readings of one reply must agree on."""
        return (self.outcome is Outcome.UNREADABLE, self.action, self.direction, self.target, self.amount)


def read_deed(answer: Answer, allowed: Collection[str]) -> Deed:
    """Read the reply to an action question; `allowed` are the deeds that there are beside moving.

    A deed that is done to another agent names it in `target`, in an object: a number, or a text that holds no other.
    """

    def interpret(found: dict[str, Any]) -> ActionReading | None:
        return _interpret(found, allowed)

    found = read_as(answer, interpret, Deed)
    assert isinstance(found, Deed), "both ways to make one make a Deed"
    return found


def _interpret(found: dict[str, Any], allowed: Collection[str]) -> Deed | None:
    fields = fields_of(found)
    asked = fields.get("action")
    deed = _MEANT.get(asked.strip().lower()) if isinstance(asked, str) else None
    if deed is None or deed not in allowed or isinstance(fields, Conflicting):
        plain = interpret_action(found)
        if plain is None:
            return None
        return Deed(plain.outcome, plain.action, plain.direction, plain.memory, plain.reasoning)
    named, given = _first(found, _TARGETS), _first(found, _AMOUNTS)
    target = _number(named) if deed in AIMED else None
    amount = _number(given) if deed == SHARE else None
    if deed in AIMED and target is None or deed == SHARE and not amount:
        return Deed(Outcome.UNREADABLE)
    told = [fields.get(name) for name in ("memory", "reasoning")]
    as_asked = asked == deed and (deed not in AIMED or target == found.get("target"))
    exact = fields is found and as_asked and (deed != SHARE or amount == found.get("amount"))
    exact = exact and all(text is None or isinstance(text, str) for text in told)
    memory, reasoning = map(text_of, told)
    return Deed(Outcome.CHOSEN if exact else Outcome.REPAIRED, deed, None, memory, reasoning, target, amount)


def _first(found: dict[str, Any], names: Collection[str]) -> object:
    return next((found[name] for name in names if found.get(name) is not None), None)


def _number(value: object) -> int | None:
    """Return the whole number from 0 that a value is or names; None where it is none."""
    if isinstance(value, str):
        match = _NUMBER.fullmatch(value.strip())
        return int(match[1]) if match else None
    whole = isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 10**6
    return int(value) if whole and isinstance(value, int) else None


@lru_cache(maxsize=4096)
def reply(action: str, *, target: int | None = None, amount: int | None = None) -> str:
    """Return the reply that asks for a direction, for staying, or for a deed."""
    moves = action not in (*DEEDS, "stay")
    found: dict[str, Any] = {"action": "move", "direction": action} if moves else {"action": action}
    further = {"target": target, "amount": amount}
    found |= {name: value for name, value in further.items() if value is not None}
    return json.dumps({**found, "memory": "", "reasoning": "A draw among the legal actions."})
