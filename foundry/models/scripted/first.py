"""The policy that does the same thing always, in any world."""

from __future__ import annotations

from foundry.errors import InputError
from foundry.models.base import Reply, Request
from foundry.models.scripted.base import ScriptedModel
from foundry.worlds.base import Question


class First(ScriptedModel):
    """Always gives the first of the legal replies; where they are not listed, the one that does nothing.

    It plays every world that scripted/random plays, and is as blind as that one without being as varied.
    """

    @property
    def kinds(self) -> None:
        """Any kind: what can be answered stands with each question."""

    def check(self, question: Question) -> None:
        """Refuse a world that says neither.

        Raises:
            InputError: it does not.
        """
        self._first(question)

    def reply(self, request: Request) -> Reply:
        """Answer one request."""
        return Reply(text=self._first(request))

    def _first(self, asked: Question | Request) -> str:
        first = asked.options[0] if asked.options else asked.idle
        if first is None:
            raise InputError(
                f"Model '{self.name}' cannot act in this world: its questions of kind '{asked.kind}' name neither "
                "replies that are legal (Question.options) nor one that does nothing (Question.idle); choose another "
                "policy."
            )
        return first
