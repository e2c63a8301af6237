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
    for other in near:
        gained = with_part(own, other["persona"], part)
        if gained != own:
            lost = {"persona": with_part(other["persona"], own, part)}
            told = {
                key: [one | lost if one["id"] == other["id"] else one for one in question.observation.get(key, ())]
                for key in ("neighbours", "seen")
            }
            return observing(question, persona=gained, **told)
    return None
