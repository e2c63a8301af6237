"""Runs of worlds of rounds, played by scripted policies in this process and read back as arrays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any

import msgspec
import numpy as np

from analysis.any.any_arrays import COMMON, objects
from analysis.any.any_run import AnyRun
from analysis.arrays import OUTCOMES
from analysis.rounds.rounds_run import RoundsRun
from foundry.composing.compose import compose
from foundry.composing.preflight import scenario_of
from foundry.conformance.playing import play, request_of
from foundry.models.base import Model, ModelInfo, RunContext, ScriptedModel
from foundry.records import Message, Record, RoundStep
from foundry.running.build import build
from foundry.worlds.base import Answer, Question
from foundry.worlds.rounds.rounds_world import RoundsScenario


@cache
def composed(*overrides: str) -> Mapping[str, Any]:
    """Return the configuration of a condition."""
    found = compose(list(overrides))
    assert found is not None
    return found.conditions[0].config


def scripted_run(*overrides: str, seed: int = 0) -> RoundsRun:
    """Return the run of a world and a model with this seed: `scripted_run("world=bar", "model=scripted/coin")`."""
    config = composed(*overrides)
    scenario = scenario_of(config)
    assert isinstance(scenario, RoundsScenario)
    return arrays(scenario, records(scenario, build(config["model"]), seed), config["world"])


def records(scenario: RoundsScenario, model: Model, seed: int) -> Sequence[Record]:
    """Return what an episode writes that a policy plays."""
    placed = model.in_run(RunContext(seed, seed, scenario.personas(seed), ModelInfo(model.name)))
    assert isinstance(placed, ScriptedModel)

    def answers(questions: Iterable[Question]) -> list[Answer]:
        return [Answer(placed.reply(request_of(one, seed)).text) for one in questions]

    return play(scenario.start(seed), answers, most=scenario.count_calls() + 1).records


def arrays(scenario: RoundsScenario, written: Sequence[Record], settings: Mapping[str, Any]) -> RoundsRun:
    """Return the records of an episode as arrays."""
    steps = [one for one in written if isinstance(one, RoundStep)]
    said = [one for one in written if isinstance(one, Message)]
    declared = scenario.declared()
    general = AnyRun(
        id="played",
        declared=declared,
        step=np.array([one.step for one in steps], dtype=np.int64),
        agent=np.array([one.agent for one in steps], dtype=np.int64),
        kind=objects(one.kind for one in steps),
        action=objects(one.action if isinstance(one.action, str) else None for one in steps),
        number=np.array([one.action if isinstance(one.action, int | float) else np.nan for one in steps]),
        outcome=np.array([OUTCOMES.index(one.outcome) for one in steps], dtype=np.int64),
        utility=np.array([np.nan if one.utility is None else one.utility for one in steps]),
        said=objects(one.message for one in steps),
        deliveries=np.array([(one.step, one.sender, one.recipient) for one in said], dtype=np.int64).reshape(-1, 3),
        agents=scenario.agents,
        personas=({},) * scenario.agents,
        world=settings,
    )
    columns = {
        key: objects(getattr(one, key) for one in steps) for key in declared.streams["steps"] if key not in COMMON
    }
    streams: dict[str, list[dict[str, Any]]] = {}
    for one in written:
        streams.setdefault(one.stream, []).append(msgspec.to_builtins(one))
    return RoundsRun.of(general, columns=columns, streams=streams)


def answered_run(scenario: RoundsScenario, answers: Iterable[str], settings: Mapping[str, Any]) -> RoundsRun:
    """Return the run in which the questions are answered so, in their order; of an iterator no more than is needed."""
    left = iter(answers)
    written = play(
        scenario.start(0), lambda asked: [Answer(next(left)) for _ in asked], most=scenario.count_calls() + 1
    ).records
    return arrays(scenario, written, settings)
