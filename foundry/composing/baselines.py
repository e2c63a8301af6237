"""The scripted baselines of a sweep: bounds that a model's behaviour is read against, on the same worlds and seeds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import yaml

from foundry import paths
from foundry.composing.preflight import scenario_of
from foundry.running.build import build
from foundry.sweep import Condition, Sweep, expand, settings_key

NAMES = ("scripted/random", "scripted/wander", "scripted/stay", "scripted/oracle")
"""Random walks in 2D and in 3D, no motion, and the policy that knows the way; each where it can act."""


def baselines_of(sweep: Sweep) -> Sweep:
    """Return the sweep of baselines: every world of the given one, with all the seeds it was run with.

    Scripted policies read no prompt, so each world is run with the first prompt it was run with. A policy that the
    sweep itself compares is left out: its runs are there.

    Raises:
        InputError: a world cannot be built.
    """
    worlds: dict[str, list[Condition]] = {}
    for condition in sweep.conditions:
        worlds.setdefault(settings_key(condition.config["world"]), []).append(condition)
    compared = {condition.config["model"]["name"] for condition in sweep.conditions}
    models = [_model(name) for name in NAMES if name not in compared]
    conditions = [one for conditions in worlds.values() for one in _conditions(conditions, models)]
    return expand(("baselines of", *sweep.asked), conditions)


def _model(name: str) -> dict[str, Any]:
    text = (paths.conf_dir() / "model" / f"{name}.yaml").read_text(encoding="utf-8")
    config: dict[str, Any] = yaml.safe_load(text)
    return config


def _conditions(conditions: list[Condition], models: list[dict[str, Any]]) -> Iterator[Condition]:
    """Yield one world's condition for each model that can act in it."""
    first = conditions[0]
    scenario = scenario_of(first.config)
    kinds = set(scenario.kinds)
    seeds = tuple(sorted({seed for condition in conditions for seed in condition.seeds}))
    factors = {key: value for key, value in first.factors.items() if _is_of_world(key)}
    for model in models:
        if kinds <= set(build(model).kinds):
            own = {key: value for key, value in first.config.items() if key != "fork"}  # from the first step on
            config = {**own, "model": model, "sampling_seed": None}
            yield Condition({**factors, "model": model["name"]}, config, seeds, scenario.declared())


def _is_of_world(key: str) -> bool:
    return key.lstrip("+").split(".")[0] not in ("model", "prompt", "sampling_seed", "seed")
