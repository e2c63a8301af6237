"""Finds the exact prompt of one call of a run, without asking any server for an answer."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass

from foundry.composing.preflight import prompt_of, scenario_of
from foundry.episode import Asker, answer_of
from foundry.errors import InputError
from foundry.expansion import Sweep, settings_key
from foundry.models.answers.base import Answers
from foundry.models.base import ChatMessage, Model, ModelInfo, Reply, Request
from foundry.models.wrappers.base import Wrapper
from foundry.running.build import asker_of, build
from foundry.worlds.base import World


@dataclass(frozen=True)
class FoundPrompt:
    """A prompt, and how many earlier answers had to be taken as silence because they are not in the cache."""

    messages: tuple[ChatMessage, ...]
    assumed_silent: int


class _CachedOrSilent(Wrapper):
    """Answers from the cache, and with nothing where it does not reach."""

    def __init__(self, inner: Model, answers: Answers | None) -> None:
        super().__init__(inner)
        self._answers = answers
        self.silent = 0

    async def ask(self, request: Request) -> Reply:
        """Answer one request."""
        found = self._answers.get([request.key]) if self._answers else {}
        self.silent += request.key not in found
        return found.get(request.key, Reply(text=""))


def find_prompt(
    sweep: Sweep,
    infos: Mapping[str, ModelInfo],
    answers: Answers | None,
    *,
    step: int,
    agent: int,
    kind: str | None,
) -> FoundPrompt:
    """Return the prompt that an agent gets at a step of the sweep's first run.

    Args:
        sweep: the sweep.
        infos: what the servers said; a model that is missing is taken as never asked before.
        answers: the answer cache, or None.
        step: 1-based step.
        agent: agent id.
        kind: kind of question; None for `action` where the world asks it, else for the first that it asks.

    Raises:
        InputError: this run asks no such question.
    """
    run = sweep.runs[0]
    config = sweep.config(run)
    scenario = scenario_of(config)
    if kind is None:
        kind = "action" if "action" in scenario.kinds else scenario.kinds[0]
    if kind not in scenario.kinds:
        raise InputError(f"World '{scenario.name}' asks no '{kind}': its kinds are {', '.join(scenario.kinds)}.")
    model: Model = build(config["model"])
    readers: list[_CachedOrSilent] = []

    def reading(one: Model) -> Model:
        if not one.costs:
            return one
        readers.append(_CachedOrSilent(one, answers))
        return readers[-1]

    info = infos.get(settings_key(config["model"]), ModelInfo(name=model.name))
    asker = asker_of(config, scenario, prompt_of(config), model.wrapped(reading), info)
    messages = asyncio.run(_search(scenario.start(run.seed), asker, (step, agent, kind)))
    return FoundPrompt(messages, sum(reader.silent for reader in readers))


async def _search(world: World, asker: Asker, wanted: tuple[int, int, str]) -> tuple[ChatMessage, ...]:
    step, agent, kind = wanted
    agents: set[int] = set()
    while not world.finished:
        questions = world.pending()
        agents |= {question.agent for question in questions}
        for question in questions:
            if (question.step, question.agent, question.kind) == wanted:
                return asker.prompt.render(question)
        if questions[0].step > step:
            break
        replies = await asker.ask_all([asker.request(question) for question in questions])
        world.advance([answer_of(reply) for reply in replies])
    known = f"agents {min(agents)} to {max(agents)} and steps 1 to {world.step}" if agents else "no questions"
    raise InputError(f"No {kind} question is put to agent {agent} at step {step}: the run has {known}.")
