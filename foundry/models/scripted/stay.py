"""The policy that does nothing."""

from __future__ import annotations

from foundry.errors import InputError
from foundry.models.base import Reply, Request
from foundry.models.scripted.base import ScriptedModel
from foundry.worlds.base import Question


class Stay(ScriptedModel):
    """Always gives the reply that does nothing, as the world says it: stays where it is, says nothing."""

    @property
    def kinds(self) -> None:
        """Any kind: what does nothing stands with each question."""

    def check(self, question: Question) -> None:
        """Refuse a world in which nobody can do nothing.

        Raises:
            InputError: its questions do not say what does nothing.
        """
        if question.idle is None:
            raise self._refusal(question.kind)

    def reply(self, request: Request) -> Reply:
        """Answer one request."""
        if request.idle is None:
            raise self._refusal(request.kind)
        return Reply(text=request.idle)

    def _refusal(self, kind: str) -> InputError:
        return InputError(
            f"Model '{self.name}' cannot act in this world: its questions of kind '{kind}' name no reply that does "
            "nothing (Question.idle); choose another policy, such as scripted/random."
        )
