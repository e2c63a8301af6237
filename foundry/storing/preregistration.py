"""The declaration before the runs (`preregistration.yaml`), and the record of looks at the data (`looks.jsonl`)."""

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
"""Subfolder of a sweep that exists once it is analysed."""


class LookedAt(msgspec.Struct, frozen=True, kw_only=True):
    """A pair of groups at a look, a line of the file.

    Attributes:
        factor: setting in which they differ.
        level: value of the factor in the first group.
        reference: value of the factor in the second group.
        context: other swept settings, equal in both groups.
        pairs: number of seeds with a value in both groups.
        at: time of the first look, UTC.
        settings: sorted hashes of both groups' settings, independent of other swept settings. Empty in older files.
    """

    factor: str
    level: str
    reference: str
    context: str
    pairs: int
    at: str
    settings: tuple[str, ...] = ()


def looks_of(folder: Path) -> list[LookedAt]:
    """Return all looks at a sweep, oldest first."""
    file = folder / LOOKS_FILE
    return lines_of(file.read_bytes(), LookedAt, file) if is_there(file) else []


def write_looks(folder: Path, looks: Sequence[LookedAt]) -> None:
    """Write the looks at a sweep."""
    write_atomically(folder / LOOKS_FILE, msgspec.json.Encoder().encode_lines(looks))


class Part(msgspec.Struct, frozen=True, kw_only=True):
    """A world, prompt or model: its name, and the hash of its settings without the server's address."""

    name: str
    sha256: str


class PlannedCondition(msgspec.Struct, frozen=True, kw_only=True):
    """A condition, and the seed of each of its runs by id."""

    factors: dict[str, Any]
    world: Part
    prompt: Part
    model: Part
    runs: dict[str, int]


class PlannedMeasure(msgspec.Struct, frozen=True, kw_only=True):
    """A measure that is tested.

    Attributes:
        margin: difference below which conditions count as equal; None if none was declared.
        code_sha256: hash of the signature's code, by form of world.
        widest: largest possible difference of a seed; None if the range of the measure gives it.
    """

    name: str
    margin: float | None
    code_sha256: dict[str, str]
    widest: float | None = None


class PlannedLook(msgspec.Struct, frozen=True, kw_only=True):
    """A look: the number of seeds, and the level for a single test and for the first step of Holm's correction."""

    seeds: int
    alpha: float
    alpha_in_family: float


class Preregistration(msgspec.Struct, frozen=True, kw_only=True):
    """The declarations before the runs.

    Attributes:
        made: time, UTC.
        commit: commit of foundry's clone; None outside a clone.
        models: name and digest of the weights of each model, as far as servers report them.
        seeds: all seeds in order; a look uses the first seeds.
        measures: the tested measures; all others are exploratory.
        tests: number of tests per factor: measures times pairs of levels.
        pairs: number of tested pairs of levels per factor; empty in older plans.
        method: test and correction, in words.
        alpha: total error per factor.
        left_out: omitted conditions, with reasons.
        answers_known: number of the runs' answers in the cache at that time; None if unknown.
        runs_known: analysed sweeps that contained any of the runs at that time.
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
        """Text about runs and answers known before the plan; "" if there were none."""
        if self.answers_known is None:
            answers = "an unknown number of answers"
        else:
            answers = counted(self.answers_known, "answer") if self.answers_known else ""
        parts = [answers, *(f"runs in {one}" for one in self.runs_known)]
        known = ", ".join(filter(None, parts))
        return f"known before the plan: {known}" if known else ""

    @property
    def runs(self) -> dict[str, int]:
        """The seeds of all runs by id."""
        return {run: seed for condition in self.conditions for run, seed in condition.runs.items()}


def conditions_of(sweep: Sweep) -> list[PlannedCondition]:
    """Return the conditions of a sweep in the form of a plan."""
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
    """Raise an error if the folder already has a plan or a sweep."""
    if is_there(folder / PREREGISTRATION_FILE):
        raise InputError(f"'{folder}' already has a plan, which cannot change. Use another output.dir.")
    if is_sweep(folder):
        raise InputError(f"A sweep has begun in '{folder}', but a plan must precede the runs. Use another output.dir.")


def plan_sha256(folder: Path) -> str | None:
    """Return the SHA-256 of the plan in a sweep's folder, or None."""
    file = folder / PREREGISTRATION_FILE
    return _sha256(file.read_bytes()) if is_there(file) else None


def holders_of(runs: Collection[str], folder: Path, sweeps: Iterable[Path]) -> list[str]:
    """Return the names of the analysed sweeps that contain any of these runs."""
    others = (one for one in sorted(sweeps) if is_sweep(one) and one.resolve() != folder.resolve())
    analysed = (one for one in others if (one / ANALYSIS).is_dir())
    return [one.name for one in analysed if any((one / "runs" / run / "run.json").exists() for run in runs)]


def write_preregistration(folder: Path, plan: Preregistration) -> str:
    """Write the plan into a sweep's folder, which is created if necessary; return the file's SHA-256."""
    content = to_yaml(msgspec.to_builtins(plan)).encode()
    folder.mkdir(parents=True, exist_ok=True)
    write_atomically(folder / PREREGISTRATION_FILE, content)
    return _sha256(content)


def preregistration_of(folder: Path) -> tuple[Preregistration, str] | None:
    """Return the declarations of a sweep and the SHA-256 of their file, or None."""
    file = folder / PREREGISTRATION_FILE
    if not is_there(file):
        return None
    content = file.read_bytes()
    try:
        return msgspec.convert(load_plain(content.decode(), file), Preregistration), _sha256(content)
    except ValueError as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
