"""A small policy that holds all that a model must hold, and models that break one rule each."""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from conformance.coins import PROMPT, Coins
from foundry.conformance.models import ModelCase
from foundry.conformance.playing import WorldCase
from foundry.models.base import Model, Reply, Request, RunContext, ScriptedModel

WORLD = WorldCase(Coins, lambda: PROMPT)
NUMBERS = itertools.count()


class Caller(ScriptedModel):
    """Calls heads or tails, with odds."""

    def __init__(self, name: str, odds: float = 0.5) -> None:
        super().__init__(name)
        self.odds = odds

    def call(self, observation: Mapping[str, Any], rng: Any) -> str:
        return "heads" if rng.random() < self.odds else "tails"

    def parameters(self) -> dict[str, Any]:
        return super().parameters() | {"odds": self.odds}


class Unnamed(Caller):
    def __init__(self, name: str, odds: float = 0.5) -> None:
        super().__init__("", odds)


class OtherKind(ScriptedModel):
    def shout(self, observation: Mapping[str, Any], rng: Any) -> str:
        return "heads"


class Unplain(Caller):
    def parameters(self) -> dict[str, Any]:
        return {"odds": self.odds, "of": object()}


class Restless(Caller):
    def parameters(self) -> dict[str, Any]:
        return {"odds": self.odds, "made": next(NUMBERS)}


class Quiet(Caller):
    def parameters(self) -> dict[str, Any]:
        return {}


class Remembering(Caller):
    def call(self, observation: Mapping[str, Any], rng: Any) -> str:
        return f"call {next(NUMBERS)}"


class Shuffled(Caller):
    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        return [Reply(text=f"{request.agent}") for request in reversed(requests)]

    async def ask(self, request: Request) -> Reply:
        return Reply(text=f"{request.agent}")


class Texts(Caller):
    async def ask_all(self, requests: Sequence[Request]) -> list[Any]:
        return ["heads" for _ in requests]


class Scribbling(Caller):
    def call(self, observation: Any, rng: Any) -> str:
        observation["shown"] = "mine"
        return "heads"

    def reply(self, request: Request) -> Reply:
        return super().reply(msgspec.structs.replace(request, observation=request.observation.maps[0]))  # type: ignore[attr-defined]


class Obliging(Caller):
    def reply(self, request: Request) -> Reply:
        return Reply(text="heads")


class Paid(Caller):
    costs = True

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        raise AssertionError("was asked")


class Renamed(Caller):
    def in_run(self, context: RunContext) -> Model:
        return Caller("another", self.odds)


def case(model: type[Model], settings: Mapping[str, Any] | None = None) -> ModelCase:
    return ModelCase(lambda given: model(**given), settings or {"name": "own", "odds": 0.5}, WORLD)  # type: ignore[call-arg]


SOUND = case(Caller)
BROKEN = [
    (case(Unnamed), "says its name and kinds", "name is ''"),
    (case(OtherKind, {"name": "own"}), "answers the world", "also asks call"),
    (case(Unplain), "says its parameters", "cannot be written as JSON"),
    (case(Restless), "says its parameters", "differ"),
    (case(Quiet), "tells its settings apart", "lacks odds"),
    (case(Remembering), "answers the same", "a different reply"),
    (case(Shuffled), "answers the same", "a different reply"),
    (case(Texts), "answers the same", "return a Reply"),
    (case(Scribbling), "leaves the observation as it is", "changes the observation"),
    (case(Obliging), "refuses other kinds", "raise foundry.InputError"),
    (case(Renamed), "fits into a run", "'another'"),
]
