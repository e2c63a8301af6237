"""The agents have other numbers, in the same order; numbers in texts, as in messages and memories, stay."""

from __future__ import annotations

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "rename_agents"
LEAVES = "invariance"
HIGHER = 100
"""What every number rises by."""


def edit(question: Question) -> Question:
    """Return the question with every agent's number raised, the agent's own among them."""
    seen = question.observation
    named = {
        key: [{**one, name: one[name] + HIGHER} for one in seen.get(key, ())]
        for key, name in (("neighbours", "id"), ("seen", "id"), ("received", "sender"))
    }
    touchable = [agent + HIGHER for agent in seen.get("touchable", ())]
    return observing(question, **named, agent=seen["agent"] + HIGHER, touchable=touchable)
