"""Every check of models sees what it is there for; the shipped policies and backends pass them all."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
import pytest

from conformance.coins import Coins
from foundry.conformance.finding import Status, look, name_of
from foundry.conformance.models import CHECKS, ModelCase
from foundry.conformance.playing import WorldCase
from foundry.models.base import Model, Reply, Request, RunContext
from foundry.models.scripted.base import ScriptedModel

WORLD = WorldCase(Coins)
BY_NAME = {name_of(check): check for check in CHECKS}
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
        return [Reply(text=f"{one.agent}") for one in reversed(requests)]

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


class Renamed(Caller):
    def in_run(self, context: RunContext) -> Model:
        return Caller("another", self.odds)


BROKEN = [
    (Unnamed, "says its name and kinds", "its name is ''"),
    (OtherKind, "answers the world", "also asks call"),
    (Unplain, "says its parameters", "cannot be written as JSON"),
    (Restless, "says its parameters", "differ"),
    (Quiet, "tells its settings apart", "another odds"),
    (Remembering, "answers the same", "other replies"),
    (Shuffled, "answers the same", "other replies"),
    (Texts, "answers the same", "return a Reply"),
    (Scribbling, "leaves the observation as it is", "changes the observation"),
    (Obliging, "refuses other kinds", "raise foundry.InputError"),
    (Renamed, "fits into a run", "'another'"),
]


def case(model: type[Model], settings: Mapping[str, Any] | None = None) -> ModelCase:
    return ModelCase(lambda given: model(**given), settings or {"name": "own", "odds": 0.5}, WORLD)  # type: ignore[call-arg]


@pytest.mark.parametrize("check", CHECKS, ids=name_of)
def test_a_sound_policy_passes(check):
    found = look("model own", check, case(Caller))
    assert (found.status, found.note) == (Status.PASSED, "")


@pytest.mark.parametrize(("model", "name", "words"), BROKEN, ids=[model.__name__ for model, _, _ in BROKEN])
def test_a_model_that_breaks_a_rule_fails_the_check_of_that_rule(model: type[Model], name: str, words: str):
    settings = {"name": "own"} if model is OtherKind else None
    found = look("model own", BY_NAME[name], case(model, settings))
    assert found.status is Status.FAILED and words in found.note, found


def test_every_check_is_seen_to_fail():
    assert {name for _, name, _ in BROKEN} == set(BY_NAME)


def test_a_model_that_costs_something_is_asked_nothing():
    class Paid(Caller):
        costs = True

        async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
            raise AssertionError("was asked")

    found = [look("model own", check, case(Paid)) for check in CHECKS]
    assert [one.check for one in found if one.status is Status.SKIPPED] == [
        "answers the same", "leaves the observation as it is", "refuses other kinds",
    ]  # fmt: skip
    assert not [one for one in found if one.status is Status.FAILED]
