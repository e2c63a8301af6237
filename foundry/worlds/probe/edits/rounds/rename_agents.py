"""The agents have other numbers, the last one the first; numbers in texts, as in messages, stay."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import msgspec

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing
from foundry.worlds.rounds.public_goods import agent_of
from foundry.worlds.rounds.replies import options_of
from foundry.worlds.rounds.table import RoundQuestion
from foundry.worlds.rounds.world import RoundsScenario

NAME = "rename_agents"
LEAVES = "equivariance"
_AGENT = "agent "
"""How a decision for an agent begins, where there are such."""


def edit(question: Question) -> Question:
    """Return the question with every agent's number counted from the end, the agent's own among them."""
    seen, agents = question.observation, question.observation["agents"]

    def renamed(thing: Mapping[str, Any], key: str) -> dict[str, Any]:
        return {**thing, key: None if thing.get(key) is None else agents - 1 - thing[key]}

    lists = {"received": "sender", "talk": "agent"}
    named = {key: [renamed(one, name) for one in seen.get(key, ())] for key, name in lists.items()}
    months = [{**one, "caught": one["caught"][::-1]} for one in seen.get("months", ())]
    rounds = [renamed(one, "punished") if "punished" in one else one for one in seen.get("rounds", ())]
    changed = observing(
        question, **named, months=months, rounds=rounds, given=list(seen.get("given", ()))[::-1],
        agent=agents - 1 - seen["agent"],
    )  # fmt: skip
    if isinstance(changed, RoundQuestion) and changed.legal and changed.legal.labels:
        labels = tuple(_renamed(one, agents) for one in changed.legal.labels)
        legal = msgspec.structs.replace(changed.legal, labels=labels)
        return replace(changed, legal=legal, options=options_of(legal))
    return changed


def expected(action: Any, scenario: RoundsScenario) -> Any:
    """Return the action for the same agent under its other number; all others are what they were."""
    return _renamed(action, scenario.agents)


def _renamed(action: str, agents: int) -> str:
    return f"{_AGENT}{agents - 1 - agent_of(action)}" if action.startswith(_AGENT) else action
