"""Runs of worlds of rounds, played by scripted policies in this process and read back as arrays."""

import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from analysis.load import read_records, read_run
from analysis.rounds.rounds_run import RoundsRun
from foundry.conformance.playing import play, request_of
from foundry.expansion import Condition, expand
from foundry.models.base import Model, ModelInfo, RunContext, ScriptedModel
from foundry.records import Record
from foundry.running.build import build
from foundry.storing.run_writer import RunWriter
from foundry.storing.store import SweepFolder
from foundry.worlds.base import Answer, Question
from foundry.worlds.rounds.rounds_world import RoundsScenario

CONF = Path(__file__).parents[2] / "conf"


def scripted_run(world: str, policy: str, seed: int = 0, **changes: Any) -> RoundsRun:
    """Return the run of a shipped world and policy with this seed: `scripted_run("bar", "coin", steps=9)`."""
    settings = yaml.safe_load((CONF / "world" / f"{world}.yaml").read_text("utf-8"))["world"] | changes
    model = yaml.safe_load((CONF / "model" / "scripted" / f"{policy}.yaml").read_text("utf-8"))
    scenario = build(settings)
    assert isinstance(scenario, RoundsScenario)
    return arrays(scenario, records(scenario, build(model), seed), settings)


def records(scenario: RoundsScenario, model: Model, seed: int) -> Sequence[Record]:
    placed = model.in_run(RunContext(seed, seed, scenario.personas(seed), ModelInfo(model.name)))
    assert isinstance(placed, ScriptedModel)

    def answers(questions: Iterable[Question]) -> list[Answer]:
        return [Answer(placed.reply(request_of(question, seed)).text) for question in questions]

    return play(scenario.start(seed), answers, most=scenario.count_calls() + 1).records


def arrays(scenario: RoundsScenario, written: Sequence[Record], settings: Mapping[str, Any]) -> RoundsRun:
    config = {"world": settings, "model": {"name": "m"}, "prompt": {"name": "p"}, "sampling_seed": None}
    sweep = expand([], [Condition({}, config, (0,), scenario.declared())])
    with tempfile.TemporaryDirectory() as path:
        (folder,) = SweepFolder.create(Path(path) / "sweep", sweep, {}, []).runs()
        writer = RunWriter(folder, "")
        writer.append(written)
        writer.close()
        run = read_run(folder, read_records(folder, None))
    assert isinstance(run, RoundsRun)
    return run


def answered_run(scenario: RoundsScenario, answers: Iterable[str], settings: Mapping[str, Any]) -> RoundsRun:
    """Return the run in which the questions are answered so, in their order; of an iterator no more than is needed."""
    left = iter(answers)
    written = play(
        scenario.start(0), lambda asked: [Answer(next(left)) for _ in asked], most=scenario.count_calls() + 1
    ).records
    return arrays(scenario, written, settings)
