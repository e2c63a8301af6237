"""What can be chosen is listed in another order; each option is called what it was called.

Options are turned round: those that stood before a drawn one are listed at the end. A part names that place, so that
`permute_options.2` lists first what was listed second.
"""

from __future__ import annotations

from foundry.worlds.base import Question, Scenario
from foundry.worlds.probe.editing import drawn, observing

NAME = "permute_options"
LEAVES = "invariance"
_LISTS = ("names", "choices")
"""Keys of what can be chosen, where a world lists it."""


def parts(scenario: Scenario) -> tuple[str, ...]:
    """Return the places that can come first, from the second on."""
    most = max((len(actions.labels) for actions in scenario.actions().values()), default=0)
    return tuple(str(place) for place in range(2, most + 1))


def edit(question: Question, part: str | None = None) -> Question:
    """Return the question with its options turned round; as it was where there is no such place."""
    listed = {key: question.observation[key] for key in _LISTS if key in question.observation}
    turned = {}
    for key, options in listed.items():
        first = drawn(question, NAME, range(1, len(options))) if part is None else int(part) - 1
        turned[key] = [*options[first or 0 :], *options[: first or 0]]
    return observing(question, **turned)
