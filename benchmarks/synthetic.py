"""Writes made-up records of large sweeps, which have the shape and size of played records."""

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from analysis.tables.texts import write_numbers
from foundry.declared import Declared, keys_of
from foundry.expansion import Condition, expand
from foundry.records import Call, Counts, GridStep, Message, Outcome, RunSummary
from foundry.storing.run_writer import RunWriter, write_run_summary
from foundry.storing.store import RunFolder, SweepFolder

GRID = Declared(form="grid", streams=keys_of((GridStep, Message)))
DIRECTIONS = {1: "up", 2: "down", 3: "left", 4: "right"}
OFFSETS = np.array([(0, 0), (0, 1), (0, -1), (-1, 0), (1, 0)])
SHARE_OF_SPEAKERS = 0.3
PROMPT = (
    "You are Agent %d in a 2D world with multiple places. "
    + 40 * "Each line of a prompt is about as long as this one. "
)
OUTCOMES = [Outcome.CHOSEN] * 97 + [Outcome.REPAIRED, Outcome.UNREADABLE, Outcome.TRUNCATED]


def sweep(path: Path, *, agents: int, steps: int, models: int = 1, seeds: int = 1) -> SweepFolder:
    """Create a sweep without played runs, with as much space per agent as in the shipped world."""
    half_size = max(25, round(np.sqrt(130 * agents) / 2))
    places = [
        {"name": name, "type": name, "center": [sign * half_size // 2, 0], "extent": [5, 5], "capacity": 12}
        for name, sign in (("cafe", -1), ("library", 1))
    ]
    fires = [{"name": "fire1", "start": 3, "position": [15, 10], "intensity": 0.8, "radius": 15}]
    conditions = []
    for number in range(models):
        world = {
            "name": "synthetic", "half_size": half_size, "agents": agents, "steps": steps, "places": places,
            "fires": fires, "personas": {}, "communication_distance": 8,
        }  # fmt: skip
        config = {
            "world": world,
            "model": {"name": f"model-{number}"},
            "prompt": {"name": "paper"},
            "sampling_seed": None,
        }
        factors = {"model": f"model-{number}"}
        conditions.append(Condition(factors=factors, config=config, seeds=tuple(range(seeds)), declared=GRID))
    return SweepFolder.create(path, expand(["-m", f"seed=0-{seeds - 1}"], conditions), {}, [])


def write_run(folder: RunFolder, prompt: str = PROMPT) -> None:
    """Write a complete run of agents that walk at random; in a prompt, %d stands for the agent."""
    world = folder.config()["world"]
    agents, half = world["agents"], world["half_size"]
    rng = np.random.default_rng(folder.run.seed)
    cells = rng.integers(-half, half, size=(agents, 2), endpoint=True)
    writer = RunWriter(folder, msgspec.json.encode(folder.config()).decode())
    for step in range(1, world["steps"] + 1):
        choice = rng.integers(0, 5, size=agents)
        after = np.clip(cells + OFFSETS[choice], -half, half)
        records = _records(step, cells, after, choice, rng)
        _write_calls(writer, records, prompt)
        writer.append(_deliveries(records))
        writer.append(records)
        cells = after
    writer.close()
    write_run_summary(folder, summary(folder, writer.counts))


def _records(step: int, cells: Any, after: Any, choice: Any, rng: np.random.Generator) -> list[GridStep]:
    neighbours: list[list[int]] = [[] for _ in cells]
    for first, other in sorted(cKDTree(cells).query_pairs(8.0)):
        neighbours[first].append(other)
        neighbours[other].append(first)
    speaks, luck = rng.random(len(cells)) < SHARE_OF_SPEAKERS, rng.integers(0, len(OUTCOMES), size=(len(cells), 2))
    return [
        GridStep(
            step=step, agent=agent, x=x, y=y, x_next=x_next, y_next=y_next, place=None, fires=(),
            neighbours=tuple(sorted(neighbours[agent])),
            message=f"I am agent {agent}, at ({x}, {y}) in step {step}, and I say so." if speaks[agent] else None,
            action="move" if choice[agent] else "stay", direction=DIRECTIONS.get(int(choice[agent])),
            moved=(x, y) != (x_next, y_next), memory=f"At step {step} I was at ({x}, {y}).",
            reasoning="It seemed better to go there than to stay where everybody else already is.",
            message_reasoning="", outcome=OUTCOMES[luck[agent, 0]], message_outcome=OUTCOMES[luck[agent, 1]],
        )
        for agent, ((x, y), (x_next, y_next)) in enumerate(zip(cells.tolist(), after.tolist(), strict=True))
    ]  # fmt: skip


def _deliveries(records: list[GridStep]) -> list[Message]:
    return [
        Message(step=record.step, sender=record.agent, recipient=other, text=record.message)
        for record in records
        if record.message is not None
        for other in record.neighbours
    ]


def _write_calls(writer: RunWriter, records: list[GridStep], prompt: str) -> None:
    for kind in ("message", "action"):
        writer.append_calls(
            Call(
                step=record.step, agent=record.agent, kind=kind, model="model-0", digest=None,
                key=f"{record.step}-{record.agent}-{kind}", seed=record.step * 7919 + record.agent,
                messages=[{"role": "user", "content": prompt % record.agent}],
                parameters={"temperature": 0.7}, text=f'{{"message": "{record.message}", "x": {record.x}}}',
                thinking=None, ending="stop", prompt_tokens=500, output_tokens=60, timings={"total": 1.0}, attempts=(),
                host=None, cached=False,
            )
            for record in records
        )  # fmt: skip


def summary(folder: RunFolder, counts: Counts) -> RunSummary:
    """Return the summary of a complete run."""
    config = folder.config()
    return RunSummary(
        run=folder.id, status="complete", world=config["world"]["name"], model=config["model"]["name"], prompt="paper",
        seed=config["seed"], sampling_seed=None, foundry_version="0", python_version="3", packages={}, git_commit=None,
        model_digest=None, server_version=None, counts=counts, started="", ended="", duration_s=1.0, error=None,
        error_type=None, traceback=None, records_sha256={},
    )  # fmt: skip


def write_signatures(folder: SweepFolder, measures: int) -> None:
    """Write a table of signatures with as many columns as the analysis writes."""
    names = [f"signature_{number // 10}.measure_{number % 10}" for number in range(measures)]
    values = np.random.default_rng(0).random((len(folder.sweep.runs), measures)).round(6)
    frame = pd.DataFrame(values, columns=names)
    frame.insert(0, "run", [run.id for run in folder.sweep.runs])
    folder.analysis_dir.mkdir(exist_ok=True)
    write_numbers(folder.signatures_path.with_suffix(""), frame, "")
