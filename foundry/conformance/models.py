"""Checks of models: parameters() contains everything that affects an answer, and a policy is deterministic.

The checks of models never ask a model that costs money or time; `foundry doctor` asks such models.
"""

import asyncio
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import msgspec

from foundry.conformance.playing import Broken, Skipped, WorldCase, request_of, require
from foundry.errors import FoundryError, InputError
from foundry.expansion import without_servers
from foundry.models.base import Model, ModelInfo, Reply, Request, RequestKeys, RunContext
from foundry.worlds.base import ABORTED, LENGTH, STOPPED

_MOST = 60
"""Maximum number of questions to a model."""
_NAMES = ("_target_", "name")


@dataclass(frozen=True)
class ModelCase:
    """A model with its settings, and a world that asks the questions for its checks."""

    build: Callable[[Mapping[str, Any]], Model]
    settings: Mapping[str, Any]
    world: WorldCase

    def make(self) -> Model:
        """Build and return a new model."""
        return self.build(self.settings)

    def asked(self) -> list[Request]:
        """Return the first questions of an episode as requests; raise Skipped if the model's answers cost something."""
        model = self.make()
        if model.costs:
            raise Skipped("its answers cost something: check it with foundry doctor")
        seed = self.world.seed
        requests = [request_of(question, seed) for question in self.world.usual.questions][:_MOST]
        return [request for request in requests if model.kinds is None or request.kind in model.kinds]

    def placed(self) -> Model:
        """Return the model prepared for a run of the world."""
        model, seed = self.make(), self.world.seed
        return model.in_run(RunContext(seed, seed, self.world.scenario.personas(seed), ModelInfo(model.name)))


def says_its_name_and_kinds(case: ModelCase) -> None:
    """The model has a name, and its attribute `kinds` is a tuple of kinds of question, or None for all kinds."""
    model = case.make()
    is_name = isinstance(model.name, str) and bool(model.name)
    require(is_name, f"the model's name is {model.name!r}: set self.name to a text")
    plain = model.kinds is None or (
        isinstance(model.kinds, tuple) and all(isinstance(kind, str) for kind in model.kinds)
    )
    require(plain, f"kinds is {model.kinds!r}: give a tuple of texts, or None for any kind")


def answers_the_world(case: ModelCase) -> None:
    """The model answers every kind of question that the world asks."""
    model, scenario = case.make(), case.world.scenario
    missing = [kind for kind in scenario.kinds if model.kinds is not None and kind not in model.kinds]
    kinds = ", ".join(model.kinds or ())
    require(
        not missing,
        f"the model answers the kinds {kinds}, but world '{scenario.name}' also asks {', '.join(missing)}: answer "
        "these kinds too",
    )
    for question in case.world.usual.questions:
        model.check(question)


def says_its_parameters(case: ModelCase) -> None:
    """`parameters()` returns values that JSON can represent, and always the same ones."""
    try:
        first, second = (msgspec.json.encode(case.make().parameters(), order="deterministic") for _ in range(2))
    except (TypeError, ValueError) as error:
        raise Broken(
            f"parameters() cannot be written as JSON ({error}): use texts, numbers, flags, lists and dicts"
        ) from error
    require(first == second, "parameters() of two equal models differ: return only the configuration")


def tells_its_settings_apart(case: ModelCase) -> str | None:
    """`parameters()` contains each number that may affect an answer, so that different models share no answers."""
    key = _key(case.make())
    settings = without_servers(case.settings)
    same = [change for change in _changes(settings) if _builds_the_same(case, change, key)]
    numbers = ", ".join(change.name for change in same if not change.is_flag)
    require(
        not numbers,
        f"parameters() lacks {numbers}: add all of these, else models with different values share cached answers",
    )
    flags = ", ".join(change.name for change in same)
    return f"check that no answer depends on {flags}, which parameters() lacks" if same else None


@dataclass(frozen=True)
class _Change:
    """A changed setting. If a changed flag has no effect, this is only noted: the flag may need another setting."""

    name: str
    settings: Mapping[str, Any]
    is_flag: bool


def _key(model: Model) -> str:
    return RequestKeys(model, None).key((), 0)


def _builds_the_same(case: ModelCase, change: _Change, before: str) -> bool:
    try:
        return _key(case.build({**case.settings, **change.settings})) == before
    except (FoundryError, TypeError, ValueError):
        return False  # the model rejects this value, so nothing can be checked


def _changes(settings: Mapping[str, Any]) -> Iterator[_Change]:
    for key, value in settings.items():
        if key in _NAMES:
            continue
        if isinstance(value, Mapping):
            for change in _changes({name: inner for name, inner in value.items() if not isinstance(inner, Mapping)}):
                yield _Change(f"{key}.{change.name}", {key: {**value, **change.settings}}, change.is_flag)
        elif isinstance(value, bool):
            yield _Change(key, {key: not value}, is_flag=True)
        elif isinstance(value, int | float):
            yield _Change(key, {key: value / 2 if value else 1}, is_flag=False)


def answers_the_same(case: ModelCase) -> None:
    """A policy and a copy of it give equal replies to equal requests, in any order of the requests."""
    requests = case.asked()
    usual, other = case.placed(), case.placed()
    first = asyncio.run(usual.ask_all(requests))
    _check_replies(first, requests)
    back = asyncio.run(other.ask_all(requests[::-1]))[::-1]
    alone = [asyncio.run(usual.ask(request)) for request in requests]
    for request, *replies in zip(requests, first, back, alone, strict=True):
        require(
            replies[0].text == replies[1].text == replies[2].text,
            f"agent {request.agent} gets a different reply if a '{request.kind}' request is repeated, comes in another "
            "order or goes to a copy of the policy: draw only from the request's generator, keep no state, and return "
            "the replies in the order of the requests",
        )


def _check_replies(replies: Sequence[Reply], requests: Sequence[Request]) -> None:
    require(len(replies) == len(requests), f"ask_all() returns {len(replies)} replies to {len(requests)} requests")
    for reply in replies:
        is_reply = isinstance(reply, Reply) and isinstance(reply.text, str)
        require(is_reply, f"a reply is {reply!r}: return a Reply with a text")
        require(
            reply.ending in (STOPPED, LENGTH, ABORTED),
            f"a reply has the ending '{reply.ending}': use '{STOPPED}', '{LENGTH}' or '{ABORTED}'",
        )


def leaves_the_observation_as_it_is(case: ModelCase) -> None:
    """Answering does not change the observation."""
    requests = case.asked()
    before = [deepcopy(dict(request.observation)) for request in requests]
    asyncio.run(case.placed().ask_all(requests))
    changed = [
        request.kind
        for request, observation in zip(requests, before, strict=True)
        if dict(request.observation) != observation
    ]
    require(
        not changed,
        f"the model changes the observation of a '{changed[0] if changed else ''}' question: change only a copy",
    )


def refuses_other_kinds(case: ModelCase) -> None:
    """The model rejects unknown kinds of question with a one-line error."""
    requests = case.asked()
    if case.make().kinds is None:
        raise Skipped("it answers any kind")
    try:
        asyncio.run(case.placed().ask(msgspec.structs.replace(requests[0], kind="no such kind")))
    except InputError:
        return
    raise Broken("it answers a question of an unknown kind: raise foundry.InputError")


def fits_into_a_run(case: ModelCase) -> None:
    """In a run, the model keeps its name, and each agent gets the same model in equal runs."""
    first, other = case.placed(), case.placed()
    for placed in (first, other):
        require(isinstance(placed, Model), f"in_run() returns {placed!r}: return a Model, such as self")
        require(
            placed.name == case.make().name,
            f"in_run() changes the model's name from '{case.make().name}' to '{placed.name}': keep the name",
        )
    is_same = first.roster() == other.roster()
    require(is_same, "in_run() assigns agents to models differently in equal runs: draw with the run's seed")
