"""What was declared before the runs (`preregistration.yaml`)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from foundry.errors import InputError, RecordError
from foundry.expansion import Sweep, identity
from foundry.storing.plain_files import is_there
from foundry.storing.plain_yaml import load_plain
from foundry.storing.run_files import ENDED_RUNS, write_atomically
from foundry.storing.sweep_file import to_yaml

PREREGISTRATION_FILE = "preregistration.yaml"


class Part(msgspec.Struct, frozen=True, kw_only=True):
    """A world, prompt or model: its name, and the hash of its settings, without how a server is reached."""

    name: str
    sha256: str


class PlannedCondition(msgspec.Struct, frozen=True, kw_only=True):
    """A condition, and the seed of each of its runs by their ids."""

    factors: dict[str, Any]
    world: Part
    prompt: Part
    model: Part
    runs: dict[str, int]


class PlannedMeasure(msgspec.Struct, frozen=True, kw_only=True):
    """A measure that is tested, and the hash of the code of its signature for each form of the worlds."""

    name: str
    margin: float | None
    code_sha256: dict[str, str]


class PlannedLook(msgspec.Struct, frozen=True, kw_only=True):
    """A look: at so many seeds, with this level for a single test, and at the first step of Holm's correction."""

    seeds: int
    alpha: float
    alpha_in_family: float


class Preregistration(msgspec.Struct, frozen=True, kw_only=True):
    """What was declared before the runs.

    Attributes:
        made: when, UTC.
        foundry: its version.
        commit: that of the clone that it ran from; None outside one.
        asked: the overrides.
        conditions: what is compared.
        models: name and digest of the weights of each model, as far as servers told.
        seeds: all seeds in their order; a look is at the first of them.
        measures: those that are tested; all else explores.
        tests: how many tests each factor has: measures times pairs of its levels.
        method: how is tested and corrected, in words.
        alpha: error in all of each factor.
        looks: in their order.
        left_out: what is left out, and why.
    """

    made: str
    foundry: str
    commit: str | None
    asked: list[str]
    conditions: list[PlannedCondition]
    models: list[dict[str, Any]]
    seeds: list[int]
    measures: list[PlannedMeasure]
    tests: dict[str, int]
    method: str
    alpha: float
    looks: list[PlannedLook]
    left_out: list[str]

    @property
    def runs(self) -> dict[str, int]:
        """The seeds of all runs by their ids."""
        return {run: seed for condition in self.conditions for run, seed in condition.runs.items()}


def conditions_of(sweep: Sweep) -> list[PlannedCondition]:
    """Return the conditions of a sweep as a plan has them."""
    runs: list[dict[str, int]] = [{} for _ in sweep.conditions]
    for run in sweep.runs:
        runs[run.condition][run.id] = run.seed
    return [
        PlannedCondition(factors=dict(one.factors), runs=own, **_parts(identity(one.config)))
        for one, own in zip(sweep.conditions, runs, strict=True)
    ]


def _parts(config: Mapping[str, Any]) -> dict[str, Part]:
    return {
        role: Part(name=str(config[role]["name"]), sha256=_sha256(json.dumps(config[role], sort_keys=True).encode()))
        for role in ("world", "prompt", "model")
    }


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def check_before_runs(folder: Path) -> None:
    """Refuse to declare anything in a folder that has a plan, or runs that have ended.

    Raises:
        InputError: it has.
    """
    if is_there(folder / PREREGISTRATION_FILE):
        raise InputError(f"'{folder}' has a plan already, which stays as it is: name another output.dir.")
    number = len(list(folder.glob(ENDED_RUNS)))
    if number:
        raise InputError(
            f"{number} runs in '{folder}' have ended, and a plan is made before the runs: name another output.dir."
        )


def write_preregistration(folder: Path, plan: Preregistration) -> str:
    """Write the plan into a sweep's folder, which need not be there; returns the SHA-256 of the file."""
    content = to_yaml(msgspec.to_builtins(plan)).encode()
    folder.mkdir(parents=True, exist_ok=True)
    write_atomically(folder / PREREGISTRATION_FILE, content)
    return _sha256(content)


def preregistration_of(folder: Path) -> tuple[Preregistration, str] | None:
    """Return what was declared of a sweep, and the SHA-256 of the file; None where nothing was.

    Raises:
        RecordError: the file cannot be read.
    """
    file = folder / PREREGISTRATION_FILE
    if not is_there(file):
        return None
    content = file.read_bytes()
    try:
        return msgspec.convert(load_plain(content.decode(), file), Preregistration), _sha256(content)
    except ValueError as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
