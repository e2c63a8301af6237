"""Estimates the time and the tokens of a sweep by a few calls with its real prompts."""

import asyncio
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import msgspec

from foundry.composing.planning import PlannedRun
from foundry.composing.preflight import prompt_of, scenario_of
from foundry.doctor.hours import PRICED, price_of, spread_questions
from foundry.episode import Asker
from foundry.expansion import Sweep, settings_key
from foundry.models.base import Loaded, Model, Request
from foundry.models.serving import Price, serving_of
from foundry.models.wrappers.retried import RetriedModel
from foundry.prompts.prompt import Prompt
from foundry.running.build import build, members_of
from foundry.running.load import BURST, LoadResult, measure_load
from foundry.texts import in_words
from foundry.worlds.base import Question, Scenario

MOST_OPEN = 16
"""Assumed number of runs that are played at once."""


@dataclass(frozen=True)
class Use:
    """A combination of a model, a world and a prompt that occurs in the sweep.

    Attributes:
        model: the model without cache, limit and repeated tries; it may be a member of a population.
        key: key of the world, the prompt, and the model or population that the sweep names.
        runs: number of runs of the sweep with this key.
    """

    model: Model
    scenario: Scenario
    prompt: Prompt
    seed: int
    key: str
    runs: int


def uses_of(sweep: Sweep, scenarios: Mapping[str, Scenario]) -> Iterator[Use]:
    """Yield each model on a server, once for each of its worlds and prompts in the sweep."""
    runs = Counter(key_of(sweep.conditions[run.condition].config) for run in sweep.runs)
    seen: set[str] = set()
    for condition in sweep.conditions:
        key = key_of(condition.config)
        if key in seen:
            continue
        seen.add(key)
        scenario = scenarios[settings_key(condition.config["world"])]
        for model in members_of(build(condition.config["model"])):
            if model.costs:
                yield Use(model, scenario, prompt_of(condition.config), condition.seeds[0], key, runs[key])


def key_of(config: Mapping[str, Any]) -> str:
    """Return a text that is equal for configurations with the same model, world and prompt."""
    return settings_key({name: config[name] for name in ("world", "prompt", "model")})


def request_of(use: Use, question: Question) -> Request:
    """Return the request for a question, as the sweep makes it."""
    return Asker.create(use.model, use.prompt, digest=None, seed=use.seed).request(question)


def with_tries(use: Use) -> Use:
    """Return a copy of `use` whose model repeats failed calls, as in a sweep."""
    return replace(use, model=RetriedModel(use.model, serving_of(use.model).retry))


async def measured_calls(use: Use) -> LoadResult:
    """Measure the time of calls, first one by one, then all at once.

    The prompts come from all parts of an episode. A short episode has too few prompts, so some are sent twice or more.
    """
    requests = [request_of(use, question) for question in spread_questions(use.scenario, use.seed, BURST)]
    more = (msgspec.structs.replace(requests[at % len(requests)], seed=at) for at in range(BURST - len(requests)))
    return await measure_load(use.model, [*requests, *more])


def on_cpu(loaded: Loaded) -> str:
    """Return a remark if a model is not completely in the GPU's memory; else an empty text."""
    return f"{loaded.on_cpu:.0%} of the model is outside the GPU's memory and runs on the CPU" if loaded.on_cpu else ""


@dataclass(frozen=True)
class Estimate:
    """The maximum number of calls to a model in a plan, and the time and tokens that they take.

    Attributes:
        alone_s: seconds of a call beside no other call.
        per_call_s: seconds per call with as many calls at once as in the plan, at most sixteen.
        prompt_tokens: prompt tokens of all calls; None if the server does not report them.
        reply_tokens: reply tokens of all calls; None if the server does not report them.
        cost: total price; None without a price or without tokens.
        note: remark on the server, or "".
    """

    model: str
    calls: int
    alone_s: float
    per_call_s: float
    prompt_tokens: int | None
    reply_tokens: int | None
    cost: float | None
    note: str = ""

    @property
    def seconds(self) -> float:
        """Estimated time of all calls, seconds."""
        return self.calls * self.per_call_s

    @classmethod
    def of(cls, use: Use, measured: LoadResult, calls: int, note: str = "") -> "Estimate":
        """Return the estimate for a number of calls. Few agents in few runs cannot use all slots of a server."""
        at_once = min(use.runs, MOST_OPEN) * len(use.scenario.start(use.seed).pending())
        means = (measured.prompt_tokens, measured.output_tokens)
        prompts, replies = (None if mean is None else round(calls * mean) for mean in means)
        return cls(
            use.model.name,
            calls,
            measured.alone_s,
            max(measured.per_call_s, measured.alone_s / max(1, at_once)),
            prompts,
            replies,
            _cost(price_of(use.model), prompts, replies),
            note,
        )

    def line(self) -> str:
        """Return the estimate as text."""
        parts = [
            f"{self.calls:,} calls take about {in_words(self.seconds)}",
            f"{self.alone_s:.2g} s for a call alone, {self.per_call_s:.2g} s per call if many are sent at once",
            ""
            if self.prompt_tokens is None or self.reply_tokens is None
            else f"about {self.prompt_tokens:,} tokens of prompts and {self.reply_tokens:,} of replies",
            "" if self.cost is None else f"cost about {self.cost:,.2f}",
            self.note,
        ]
        return "; ".join(filter(None, parts))


def _cost(price: Price | None, prompt_tokens: int | None, reply_tokens: int | None) -> float | None:
    if price is None or prompt_tokens is None or reply_tokens is None:
        return None
    return (price.prompt * prompt_tokens + price.reply * reply_tokens) / PRICED


def timed(sweep: Sweep, planned: Sequence[PlannedRun]) -> Iterator[Estimate]:
    """Measure about twenty calls of each model in each of its worlds and prompts; no answer is stored.

    Raises:
        FoundryError: a server cannot be reached, or does not answer.
    """
    calls: Counter[str] = Counter()
    for run in planned:
        key = key_of(sweep.conditions[run.run.condition].config)
        calls[key] += run.to_send
    scenarios = {
        settings_key(condition.config["world"]): scenario_of(condition.config) for condition in sweep.conditions
    }
    with asyncio.Runner() as runner:
        for use in uses_of(sweep, scenarios):
            if calls[use.key]:
                yield runner.run(_timed(use, calls[use.key]))


async def _timed(use: Use, calls: int) -> Estimate:
    retried = with_tries(use)
    try:
        await use.model.inspect()
        await retried.model.warm_up()
        measured = await measured_calls(retried)
        return Estimate.of(use, measured, calls, on_cpu(await use.model.loaded()))
    finally:
        await use.model.close()
