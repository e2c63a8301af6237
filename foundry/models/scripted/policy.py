"""What all scripted policies share."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from numpy.random import Generator

from foundry import seeding
from foundry.errors import not_found
from foundry.models.base import Model, Reply, Request

Observation: TypeAlias = Mapping[str, Any]
Policy: TypeAlias = Callable[[Observation, Generator], str]


class ScriptedModel(Model):
    """A policy: each public method it adds answers the kind of question of that name, in text.

    Such a method takes the observation, which it must not change, and a generator of its own for this call.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self._policies = _policies(self)
        # Own stream per class: a policy that wraps another draws nothing from the other's.
        self._stream = f"policy:{type(self).__name__}"

    @property
    def kinds(self) -> tuple[str, ...] | None:
        """The kinds of question it can answer; None for any."""
        return tuple(self._policies)

    def reply(self, request: Request) -> Reply:
        """Answer one request."""
        policy = self._policies.get(request.kind)
        if policy is None:
            raise not_found(f"Policy of model '{self.name}' for questions of kind", request.kind, self._policies)
        return Reply(text=policy(request.observation, self.generator(request)))

    def generator(self, request: Request) -> Generator:
        """Return the generator of this policy for this call."""
        return seeding.stream(request.seed, self._stream)

    async def ask(self, request: Request) -> Reply:
        """Answer one request."""
        return self.reply(request)

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        """Answer several requests in their order, without a task for each."""
        return [self.reply(request) for request in requests]

    def parameters(self) -> dict[str, Any]:
        """Return the policy's class; policies with settings add them."""
        return {"policy": type(self).__name__}


def _policies(model: ScriptedModel) -> dict[str, Policy]:
    return {
        name: getattr(model, name)
        for name, _ in inspect.getmembers(type(model), inspect.isfunction)
        if not name.startswith("_") and not hasattr(ScriptedModel, name)
    }
