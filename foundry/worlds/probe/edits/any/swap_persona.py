"""An agent has the persona, or one attribute of it, of an agent that was asked in another moment."""

from __future__ import annotations

from collections.abc import Sequence

from foundry.worlds.base import Question, Scenario
from foundry.worlds.probe.editing import drawn, observing
from foundry.worlds.probe.personas import attributes, with_part

NAME = "swap_persona"
LEAVES = "cause"


def parts(scenario: Scenario) -> tuple[str, ...]:
    """Return the attributes, each of which can be exchanged alone."""
    return attributes(scenario)


def edit(question: Question, others: Sequence[Question], part: str | None = None) -> Question | None:
    """Return the question of somebody else; None where all that were asked are alike."""
    own = question.observation.get("persona")
    if not own:
        return None
    gained = [with_part(own, one.observation.get("persona") or own, part) for one in others]
    found = drawn(question, NAME, [one for one in gained if one != own])
    return None if found is None else observing(question, persona=found)
