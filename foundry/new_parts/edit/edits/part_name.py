"""The edit part_name: replace its change of the agent's observation by your own."""

from foundry import Question, observing

NAME = "part_name"
LEAVES = "cause"
"""Use `invariance` if the decision should not change, and `cause` if the edit removes a possible cause of it."""


def edit(question: Question) -> Question | None:
    """Remove all messages that the agent received; None if it received none."""
    return observing(question, received=[]) if question.observation.get("received") else None
