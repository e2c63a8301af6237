"""Plans a sweep: counts its calls before they are made, and shows the exact prompt of one call."""

import asyncio
import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from foundry.composing.preflight import prompt_of, scenario_of
from foundry.episode import Asker, answer_of, play
from foundry.errors import InputError, Interrupted
from foundry.expansion import Run, Sweep, sent_key, settings_key
from foundry.models.answers.answers import Answers
from foundry.models.base import ChatMessage, Model, ModelInfo, Reply, Request
from foundry.models.serving import serving_of
from foundry.models.wrappers.wrapper import Wrapper
from foundry.prompts.prompt import Prompt
from foundry.records import Call, Record
from foundry.running.build import asker_of, build, in_run, served_by_others
from foundry.storing.determinism import Budget, Repeats, answered_calls, is_measured
from foundry.storing.store import RunFolder
from foundry.worlds.base import Scenario, World


@dataclass(frozen=True)
class PlannedRun:
    """One run of a plan.

    Attributes:
        calls: maximum number of calls of a whole episode.
        served: how many of these calls go to a server.
        cached: number of calls whose answer is in the cache, as far as the episode can be played with them; None if
            unknown.
        complete: whether the sweep's folder has the complete run.
        answered: number of calls that a server answered in the complete run; 0 if it is not complete.
        new: whether the sweep in the folder does not contain the run yet.
    """

    run: Run
    model: str
    prompt: str
    world: str
    calls: int
    served: int
    cached: int | None
    complete: bool
    answered: int
    new: bool

    @property
    def to_send(self) -> int:
        """Maximum number of calls that would be sent to a server."""
        return 0 if self.complete else self.served - (self.cached or 0)


class _Silent:
    """A recorder of an episode that stores nothing."""

    def append(self, records: Sequence[Record]) -> None: ...

    def append_calls(self, calls: Sequence[Call]) -> None: ...

    def frame(self, step: int, png: bytes) -> None: ...


class _CacheOnly(Wrapper):
    """A model that gives only cached answers. A missing answer ends the episode or, if `silent`, is an empty reply."""

    def __init__(self, inner: Model, answers: Answers | None, *, silent: bool) -> None:
        super().__init__(inner)
        self._answers = answers
        self._silent = silent
        self.hits = self.misses = 0

    async def ask(self, request: Request) -> Reply:
        return (await self.ask_all([request]))[0]

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        replies = self._answers.get([request.key for request in requests]) if self._answers else {}
        hits = sum(request.key in replies for request in requests)
        self.hits, self.misses = self.hits + hits, self.misses + len(requests) - hits
        if hits < len(requests) and not self._silent:
            raise Interrupted
        return [replies.get(request.key, Reply(text="")) for request in requests]


def _cached_only(model: Model, answers: Answers | None, *, silent: bool) -> tuple[Model, list[_CacheOnly]]:
    """Return a model that answers from the cache only, and the wrappers that count found and missing answers."""
    readers: list[_CacheOnly] = []

    def reading(member: Model) -> Model:
        if not member.costs:
            return member
        readers.append(_CacheOnly(member, answers, silent=silent))
        return readers[-1]

    return model.wrapped(reading), readers


def plan(
    sweep: Sweep, infos: dict[str, ModelInfo], answers: Answers | None, folders: dict[str, RunFolder]
) -> list[PlannedRun]:
    """Return, for each run, how many calls it will make and how many answers the cache has."""
    parts = [_Parts.of(condition.config) for condition in sweep.conditions]
    return [_planned(sweep.config(run), run, parts[run.condition], infos, answers, folders) for run in sweep.runs]


@dataclass(frozen=True)
class PlannedRepeats:
    """Number of calls that would be repeated at the end of a sweep, to measure whether its servers are deterministic.

    Attributes:
        again: number of repeated calls; half of them run alone, half beside other calls.
        beside: maximum number of these other calls.
    """

    again: int
    beside: int


def repeats(
    sweep: Sweep, planned: Sequence[PlannedRun], setting: int | str, measured: Sequence[Repeats]
) -> PlannedRepeats:
    """Return the maximum number of calls that would be repeated at the end of a sweep."""
    models = [condition.config["model"] for condition in sweep.conditions]
    calls = dict.fromkeys(map(sent_key, models), 0)
    for planned_run in planned:
        calls[sent_key(models[planned_run.run.condition])] += planned_run.to_send + planned_run.answered
    again = beside = 0
    for key, model in {sent_key(model): model for model in models if setting}.items():
        served = served_by_others(build(model))
        for member in served:
            if not is_measured(measured, str(model["name"]), member.name, member.parameters()):
                budget = Budget.of(setting, calls[key] // len(served), serving_of(member).in_flight.max)
                again += 2 * budget.again
                beside += budget.beside
    return PlannedRepeats(again, beside)


@dataclass(frozen=True)
class _Parts:
    scenario: Scenario
    prompt: Prompt
    model: Model

    @classmethod
    def of(cls, config: Mapping[str, Any]) -> "_Parts":
        return cls(scenario_of(config), prompt_of(config), build(config["model"]))


def _planned(
    config: Mapping[str, Any],
    run: Run,
    parts: _Parts,
    infos: dict[str, ModelInfo],
    answers: Answers | None,
    folders: Mapping[str, RunFolder],
) -> PlannedRun:
    folder = folders.get(run.id)
    summary = folder.summary() if folder else None
    complete = summary is not None and summary.status == "complete"
    model = parts.model
    served = {member.name for member in served_by_others(model)}
    cached: int | None = 0
    if model.costs and not complete and answers is not None:
        info = infos.get(settings_key(config["model"]))
        cached = None if info is None else asyncio.run(_count_hits(config, parts, info, answers))
    return PlannedRun(
        run=run,
        model=model.name,
        prompt=config["prompt"]["name"],
        world=parts.scenario.name,
        calls=parts.scenario.count_calls(),
        served=_served(config, parts),
        cached=cached,
        complete=complete,
        answered=answered_calls(summary, served) if summary is not None and complete and served else 0,
        new=bool(folders) and folder is None,
    )


def _served(config: Mapping[str, Any], parts: _Parts) -> int:
    calls, agents = parts.scenario.count_calls(), len(parts.scenario.personas(config["seed"]))
    try:
        placed = in_run(parts.model, config, parts.scenario, ModelInfo(parts.model.name))
    except InputError:  # reported with the plan, as a reason why the sweep cannot start
        return calls if parts.model.costs else 0
    return calls * sum(map(placed.costs_for, range(agents))) // agents


async def _count_hits(config: Mapping[str, Any], parts: _Parts, info: ModelInfo, answers: Answers) -> int:
    model, readers = _cached_only(parts.model, answers, silent=False)
    asker = asker_of(config, parts.scenario, parts.prompt, model, info)
    with contextlib.suppress(Interrupted):
        await play(parts.scenario.start(config["seed"]), asker, _Silent())
    return sum(reader.hits for reader in readers)


@dataclass(frozen=True)
class FoundPrompt:
    """A prompt of an episode, and how many earlier answers the cache lacks.

    The prompt is as if the lacking answers were empty.
    """

    messages: tuple[ChatMessage, ...]
    assumed_silent: int


def find_prompt(
    sweep: Sweep,
    infos: Mapping[str, ModelInfo],
    answers: Answers | None,
    *,
    step: int,
    agent: int,
    kind: str | None,
) -> FoundPrompt:
    """Return the prompt of one question in the first run, given its step, agent and kind.

    Without `kind`, it is the question for an action or, if the world has none, of the first kind.
    """
    run = sweep.runs[0]
    config = sweep.config(run)
    scenario = scenario_of(config)
    if kind is None:
        kind = "action" if "action" in scenario.kinds else scenario.kinds[0]
    if kind not in scenario.kinds:
        raise InputError(
            f"World '{scenario.name}' has no questions of kind '{kind}'. Its kinds: {', '.join(scenario.kinds)}."
        )
    model, readers = _cached_only(build(config["model"]), answers, silent=True)
    info = infos.get(settings_key(config["model"]), ModelInfo(name=model.name))
    asker = asker_of(config, scenario, prompt_of(config), model, info)
    messages = asyncio.run(_search(scenario.start(run.seed), asker, (step, agent, kind)))
    return FoundPrompt(messages, sum(reader.misses for reader in readers))


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
    raise InputError(f"Agent {agent} gets no {kind} question at step {step}. The run has {known}.")
