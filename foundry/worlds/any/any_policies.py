"""Policies for any world: a random one, an idle one and a constant one."""

from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.errors import InputError
from foundry.models.base import Reply, Request, ScriptedModel
from foundry.worlds.base import Question
from foundry.worlds.grid.grid_policies import STAY, act, any_of, is_on_grid, legal_moves, say
from foundry.worlds.validation import check_number


class Random(ScriptedModel):
    """Draws one of the legal actions, including the idle one; on the grid it sends no messages."""

    def __init__(self, name: str, stay_probability: float | None = None) -> None:
        """Set the probability of being idle.

        Args:
            name: name of the model.
            stay_probability: probability of the idle action; the other actions share the rest. None makes all legal
                actions equally likely.
        """
        super().__init__(name, stay_probability=stay_probability)
        if stay_probability is not None:
            check_number("model.stay_probability", stay_probability, 0, 1)
        self.stay_probability = stay_probability

    @property
    def kinds(self) -> None:
        """None, since the policy answers every kind of question, with one of the listed options."""

    def check(self, question: Question) -> None:
        """Raise InputError for a question that lists no legal replies."""
        if not question.options and not is_on_grid(question.kind, question.told):
            raise InputError(
                f"Model '{self.name}' cannot act in this world: its questions of kind '{question.kind}' list no legal "
                "replies (Question.options). Choose another policy."
            )

    def reply(self, request: Request) -> Reply:
        """Answer one request."""
        if not request.options:
            return super().reply(request)
        choices, rng = list(request.options), self.generator(request)
        return Reply(text=any_of(self._left(choices, request.idle, rng), rng))

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say nothing."""
        return say(None, reasoning="I keep to myself.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Draw a legal action."""
        choices = self._left(list(legal_moves(observation)), STAY, rng)
        return act(any_of(choices, rng), reasoning="A draw among the legal actions.")

    def _left(self, choices: list[str], idle: str | None, rng: Generator) -> list[str]:
        if self.stay_probability is None or idle not in choices or len(choices) == 1:
            return choices
        stays = rng.random() < self.stay_probability
        return [idle] if stays else [choice for choice in choices if choice != idle]


class Stay(ScriptedModel):
    """Always gives the idle reply to a question; in 2D worlds, the agent stays in place and says nothing."""

    @property
    def kinds(self) -> None:
        """None, since the policy answers every kind of question, with the question's idle reply."""

    def check(self, question: Question) -> None:
        """Raise InputError for a question without an idle reply."""
        if question.idle is None:
            raise self._refusal(question.kind)

    def reply(self, request: Request) -> Reply:
        """Answer one request."""
        if request.idle is None:
            raise self._refusal(request.kind)
        return Reply(text=request.idle)

    def _refusal(self, kind: str) -> InputError:
        return InputError(
            f"Model '{self.name}' cannot act in this world: its questions of kind '{kind}' have no idle reply "
            "(Question.idle). Choose another policy, such as scripted/random."
        )


class First(ScriptedModel):
    """Always gives the first legal reply, or the idle reply if the question lists none.

    Like scripted/random, this policy plays every world whose questions list replies, and ignores the observation; but
    it draws nothing.
    """

    @property
    def kinds(self) -> None:
        """None, since the policy answers every kind of question, with one of the listed options."""

    def check(self, question: Question) -> None:
        """Raise InputError for a question that has neither options nor an idle reply."""
        self._first(question)

    def reply(self, request: Request) -> Reply:
        """Answer one request."""
        return Reply(text=self._first(request))

    def _first(self, asked: Question | Request) -> str:
        first = asked.options[0] if asked.options else asked.idle
        if first is None:
            raise InputError(
                f"Model '{self.name}' cannot act in this world: its questions of kind '{asked.kind}' have neither "
                "legal replies (Question.options) nor an idle reply (Question.idle). Choose another policy."
            )
        return first
