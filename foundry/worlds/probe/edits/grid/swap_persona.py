"""An agent exchanges its persona, or one attribute of it, with the first neighbour that has another one."""

from __future__ import annotations

from foundry.worlds.base import Question, Scenario
from foundry.worlds.probe.editing import observing
from foundry.worlds.probe.personas import attributes, with_part

NAME = "swap_persona"
LEAVES = "cause"


def parts(scenario: Scenario) -> tuple[str, ...]:
    """Return the attributes, each of which can be exchanged alone."""
    return attributes(scenario)


def edit(question: Question, part: str | None = None) -> Question | None:
    """Return the question with the two exchanged; None where all neighbours are alike, or there are none."""
    own, near = question.observation["persona"], question.observation["neighbours"]
    for place, other in enumerate(near):
        gained = with_part(own, other["persona"], part)
        if gained != own:
            lost = {**other, "persona": with_part(other["persona"], own, part)}
            return observing(question, persona=gained, neighbours=[*near[:place], lost, *near[place + 1 :]])
    return None
