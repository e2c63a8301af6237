"""What was declared before the runs (`preregistration.yaml`), and how often data were looked at (`looks.jsonl`)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from foundry.errors import InputError, RecordError
from foundry.expansion import Sweep, identity
from foundry.storing.fresh import PREREGISTRATION_FILE as PREREGISTRATION_FILE
from foundry.storing.fresh import is_sweep
from foundry.storing.plain import is_there, load_plain
from foundry.storing.run_files import lines_of, write_atomically
from foundry.storing.sweep_file import to_yaml
from foundry.texts import counted

LOOKS_FILE = "looks.jsonl"
ANALYSIS = "analysis"
"""Folder of a sweep that was analysed."""


class LookedAt(msgspec.Struct, frozen=True, kw_only=True):
    """A pair of groups at a look, a line of the file.

    Attributes:
        factor: the setting in which they differ.
        level: its value in the first group.
        reference: its value in the second.
        context: what else was swept and is equal in both.
        pairs: seeds with a value in both.
        at: when they were looked at first, UTC.
        settings: hashes of the settings of both, sorted: they stay when another setting is swept. Empty in older files.
    """

    factor: str
    level: str
    reference: str
    context: str
    pairs: int
    at: str
    settings: tuple[str, ...] = ()


def looks_of(folder: Path) -> list[LookedAt]:
    """Return all looks at a sweep, the first first."""
    file = folder / LOOKS_FILE
    return lines_of(file.read_bytes(), LookedAt, file) if is_there(file) else []


def write_looks(folder: Path, looks: Sequence[LookedAt]) -> None:
    """Keep the looks at a sweep."""
    write_atomically(folder / LOOKS_FILE, msgspec.json.Encoder().encode_lines(looks))


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
    """A measure that is tested.

    Attributes:
        name: of the measure.
        margin: the difference below which conditions count as the same; None where none was declared.
        code_sha256: hash of the code of its signature for each form of the worlds.
        widest: the difference that no seed goes beyond; None where the range of the measure says it.
    """

    name: str
    margin: float | None
    code_sha256: dict[str, str]
    widest: float | None = None


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
        measures: the tested measures; all others are exploratory.
        tests: how many tests each factor has: measures times pairs of its levels.
        pairs: how many pairs of its levels are tested; empty in older plans.
        method: how is tested and corrected, in words.
        alpha: error in all of each factor.
        looks: in their order.
        left_out: what is left out, and why.
        answers_known: answers of its runs that the cache held when it was made; None where nobody could tell.
        runs_known: analysed sweeps that held any of its runs when it was made.
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
    pairs: dict[str, int] = {}
    answers_known: int | None = None
    runs_known: list[str] = []

    @property
    def known(self) -> str:
        """What was known of the runs when it was made, in words; "" where nothing was."""
        if self.answers_known is None:
            answers = "nobody could tell how many answers"
        else:
            answers = counted(self.answers_known, "answer") if self.answers_known else ""
        parts = [answers, *(f"runs in {one}" for one in self.runs_known)]
        known = ", ".join(filter(None, parts))
        return f"known before the plan: {known}" if known else ""

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
    """Refuse to declare anything in a folder that has a plan, or in which a sweep has begun."""
    if is_there(folder / PREREGISTRATION_FILE):
        raise InputError(f"'{folder}' has a plan already, which stays as it is: name another output.dir.")
    if is_sweep(folder):
        raise InputError(
            f"A sweep has begun in '{folder}', and a plan is made before the runs: name another output.dir."
        )


def plan_sha256(folder: Path) -> str | None:
    """Return the SHA-256 of the plan in a sweep's folder; None where there is none."""
    file = folder / PREREGISTRATION_FILE
    return _sha256(file.read_bytes()) if is_there(file) else None


def holders_of(runs: Collection[str], folder: Path, sweeps: Iterable[Path]) -> list[str]:
    """Return the names of the analysed sweeps that hold any of these runs."""
    others = (one for one in sorted(sweeps) if is_sweep(one) and one.resolve() != folder.resolve())
    analysed = (one for one in others if (one / ANALYSIS).is_dir())
    return [one.name for one in analysed if any((one / "runs" / run / "run.json").exists() for run in runs)]


def write_preregistration(folder: Path, plan: Preregistration) -> str:
    """Write the plan into a sweep's folder, which need not be there; returns the SHA-256 of the file."""
    content = to_yaml(msgspec.to_builtins(plan)).encode()
    folder.mkdir(parents=True, exist_ok=True)
    write_atomically(folder / PREREGISTRATION_FILE, content)
    return _sha256(content)


def preregistration_of(folder: Path) -> tuple[Preregistration, str] | None:
    """Return what was declared of a sweep, and the SHA-256 of the file; None where nothing was."""
    file = folder / PREREGISTRATION_FILE
    if not is_there(file):
        return None
    content = file.read_bytes()
    try:
        return msgspec.convert(load_plain(content.decode(), file), Preregistration), _sha256(content)
    except ValueError as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
