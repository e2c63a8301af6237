"""All checks of a sweep, in the order in which they are told."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterator, Mapping
from pathlib import Path
from typing import Any

from foundry.composing.preflight import prompt_of, scenario_of
from foundry.doctor.finding import Finding
from foundry.doctor.machine import check_disk, check_drawing, check_versions
from foundry.doctor.models import Use, examine_model
from foundry.expansion import Sweep, settings_key
from foundry.running.build import build, members_of
from foundry.storing.store import SweepFolder
from foundry.worlds.base import Scenario


def examine(sweep: Sweep, settings: Mapping[str, Any], *, calls: bool = True) -> Iterator[Finding]:
    """Yield what is found, as it is found.

    Args:
        sweep: the sweep as it would be run.
        settings: where and how it would be run.
        calls: whether the servers may be asked, about twenty calls a model.

    Raises:
        InputError: a world, a prompt or a model cannot be built.
    """
    yield check_versions()
    scenarios = {settings_key(one.config["world"]): scenario_of(one.config) for one in sweep.conditions}
    yield from check_drawing(scenarios.values())
    yield _disk(sweep, settings, scenarios)
    with asyncio.Runner() as runner:
        began = _begun(settings)
        for use in _uses(sweep, scenarios):
            findings = examine_model(use, began.get(use.model.name), settings["cache"]["path"], calls=calls)
            while (finding := runner.run(_next(findings))) is not None:
                yield finding
            runner.run(use.model.close())


def _begun(settings: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """Return the models that the sweep in `output.dir` began with, where there is one."""
    folder = settings["output"]["dir"]
    models = SweepFolder.open(Path(folder)).models if folder and Path(folder).exists() else []
    return {model["name"]: model for model in models}


async def _next(findings: AsyncIterator[Finding]) -> Finding | None:
    return await anext(findings, None)


def _disk(sweep: Sweep, settings: Mapping[str, Any], scenarios: Mapping[str, Scenario]) -> Finding:
    calls = images = frames = 0
    for run in sweep.runs:
        config = sweep.conditions[run.condition].config
        scenario = scenarios[settings_key(config["world"])]
        calls += scenario.count_calls()
        images += scenario.count_calls() if scenario.shows_images else 0
        every = int(config["record"]["frames"])
        frames += scenario.count_calls() // every if every else 0
    folder = Path(settings["output"]["dir"] or "outputs")
    return check_disk(folder, runs=len(sweep.runs), calls=calls, images=images, frames=frames)


def _uses(sweep: Sweep, scenarios: Mapping[str, Scenario]) -> Iterator[Use]:
    """Yield each served model once for each world and prompt that the sweep puts before it."""
    seen: set[str] = set()
    for condition in sweep.conditions:
        parts = {name: condition.config[name] for name in ("world", "prompt", "model")}
        if settings_key(parts) in seen:
            continue
        seen.add(settings_key(parts))
        scenario = scenarios[settings_key(parts["world"])]
        for model in members_of(build(parts["model"])):
            if model.costs:
                yield Use(model, scenario, prompt_of(condition.config), condition.seeds[0])
