"""Reads and writes replies with the actions gather, share, attack and reproduce."""

import json
import re
from collections.abc import Collection
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from foundry.records import Outcome
from foundry.worlds.base import Answer
from foundry.worlds.grid.parsing import ActionReading, fields_of, interpret_action, read_as, text_of
from foundry.worlds.grid.parts.parts_settings import ATTACK, FURTHER_ACTIONS, GATHER, REPRODUCE, SHARE
from foundry.worlds.replies import Conflicting

AIMED = (SHARE, ATTACK)
"""The actions that need another agent as target."""

_WORDS = {
    GATHER: ("gather", "collect", "harvest", "eat", "forage", "pick", "pick up", "採集", "集める", "採る", "食べる"),
    SHARE: ("share", "give", "donate", "transfer", "分ける", "分け与える", "与える", "渡す", "共有"),
    ATTACK: ("attack", "fight", "rob", "steal", "hit", "攻撃", "攻撃する", "奪う"),
    REPRODUCE: ("reproduce", "breed", "replicate", "繁殖", "繁殖する", "子を作る", "産む"),
}
_MEANT = {word: action for action, words in _WORDS.items() for word in words}
_NUMBER = re.compile(r"(?:(?:to|with)\s+)?(?:agent|エージェント)?\s*#?\s*(\d{1,6})", re.IGNORECASE)
_TARGETS = ("target", "agent", "to", "recipient", "victim", "target_agent", "target_id")
_AMOUNTS = ("amount", "energy", "units", "quantity")


@dataclass(frozen=True, slots=True)
class FurnishedAction(ActionReading):
    """The reading of a reply to the action question in a world where agents may gather, share, attack or reproduce.

    Attributes:
        target: id of the agent to share with or to attack, or None.
        amount: energy to share, or None.
    """

    target: int | None = None
    amount: int | None = None

    @property
    def decision(self) -> tuple[object, ...]:
        """If a reply contains several objects, these values must be the same in each of them."""
        return (self.outcome is Outcome.UNREADABLE, self.action, self.direction, self.target, self.amount)


def read_furnished_action(answer: Answer, allowed: Collection[str]) -> FurnishedAction:
    """Read the reply to an action question; staying and moving are legal, and the actions in `allowed`.

    To share or attack, the reply must give the other agent's id in `target`, as a number or a text such as "Agent 4".
    """

    def interpret(fields: dict[str, Any]) -> ActionReading | None:
        return _interpret(fields, allowed)

    action = read_as(answer, interpret, FurnishedAction)
    assert isinstance(action, FurnishedAction), "interpret and blank return a FurnishedAction"
    return action


def _interpret(candidate: dict[str, Any], allowed: Collection[str]) -> FurnishedAction | None:
    fields = fields_of(candidate)
    named_action = fields.get("action")
    action = _MEANT.get(named_action.strip().lower()) if isinstance(named_action, str) else None
    if action is None or action not in allowed or isinstance(fields, Conflicting):
        plain = interpret_action(candidate)
        if plain is None:
            return None
        return FurnishedAction(plain.outcome, plain.action, plain.direction, plain.memory, plain.reasoning)
    target = _number(_first(candidate, _TARGETS)) if action in AIMED else None
    amount = _number(_first(candidate, _AMOUNTS)) if action == SHARE else None
    if action in AIMED and target is None or action == SHARE and not amount:
        return FurnishedAction(Outcome.UNREADABLE)
    texts = [fields.get(name) for name in ("memory", "reasoning")]
    as_asked = named_action == action and (action not in AIMED or target == candidate.get("target"))
    exact = fields is candidate and as_asked and (action != SHARE or amount == candidate.get("amount"))
    exact = exact and all(text is None or isinstance(text, str) for text in texts)
    memory, reasoning = map(text_of, texts)
    return FurnishedAction(
        Outcome.CHOSEN if exact else Outcome.REPAIRED, action, None, memory, reasoning, target, amount
    )


def _first(fields: dict[str, Any], names: Collection[str]) -> object:
    return next((fields[name] for name in names if fields.get(name) is not None), None)


def _number(value: object) -> int | None:
    """Return a value that is a whole number from 0, or the number in a text such as "Agent 4"; else None."""
    if isinstance(value, str):
        match = _NUMBER.fullmatch(value.strip())
        return int(match[1]) if match else None
    whole = isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 10**6
    return int(value) if whole and isinstance(value, int) else None


@lru_cache(maxsize=4096)
def reply(action: str, *, target: int | None = None, amount: int | None = None) -> str:
    """Return the reply that chooses an action: a direction, to stay or, for example, to gather."""
    moves = action not in (*FURTHER_ACTIONS, "stay")
    fields: dict[str, Any] = {"action": "move", "direction": action} if moves else {"action": action}
    further = {"target": target, "amount": amount}
    fields |= {name: value for name, value in further.items() if value is not None}
    return json.dumps({**fields, "memory": "", "reasoning": "A draw among the legal actions."})
