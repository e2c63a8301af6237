"""The edit part_name: change what it takes from an agent's view to what you ask about."""

from foundry import Question, observing

NAME = "part_name"
LEAVES = "cause"
"""Say `invariance` if a decision should stay, and `cause` if the edit removes what may have caused it."""


def edit(question: Question) -> Question | None:
    """Take away all messages that the agent received; None where it received none."""
    return observing(question, received=[]) if question.observation.get("received") else None
