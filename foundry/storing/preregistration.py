"""Two records of a sweep: its plan (`preregistration.yaml`), and the comparisons seen so far (`looks.jsonl`)."""

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
from foundry.storing.run_files import lines_of, sha256_of, write_atomically
from foundry.storing.sweep_file import to_yaml
from foundry.texts import counted

LOOKS_FILE = "looks.jsonl"
ANALYSIS = "analysis"
"""Name of the folder inside a sweep's folder that an analysis creates."""


class LookedAt(msgspec.Struct, frozen=True, kw_only=True):
    """A comparison of two groups of runs that somebody has seen (a line of `looks.jsonl`).

    Attributes:
        factor: setting in which the groups differ, such as "model".
        level: value of this setting in the first group.
        reference: value of this setting in the second group.
        context: other swept settings, which are equal in both groups.
        pairs: number of seeds with a value in both groups.
        at: time when the comparison was first seen, UTC.
        settings: hashes of the settings of both groups, sorted; empty in older files.
    """

    factor: str
    level: str
    reference: str
    context: str
    pairs: int
    at: str
    settings: tuple[str, ...] = ()


def looks_of(folder: Path) -> list[LookedAt]:
    """Return the comparisons of a sweep that somebody has seen, oldest first."""
    file = folder / LOOKS_FILE
    return lines_of(file.read_bytes(), LookedAt, file) if is_there(file) else []


def write_looks(folder: Path, looks: Sequence[LookedAt]) -> None:
    """Write the comparisons of a sweep that somebody has seen."""
    write_atomically(folder / LOOKS_FILE, msgspec.json.Encoder().encode_lines(looks))


class Part(msgspec.Struct, frozen=True, kw_only=True):
    """The name of a world, prompt or model, and the hash of its settings without the addresses of servers."""

    name: str
    sha256: str


class PlannedCondition(msgspec.Struct, frozen=True, kw_only=True):
    """A condition of a plan; `runs` maps the id of each run to its seed."""

    factors: dict[str, Any]
    world: Part
    prompt: Part
    model: Part
    runs: dict[str, int]


class PlannedMeasure(msgspec.Struct, frozen=True, kw_only=True):
    """A measure that a plan tests.

    Attributes:
        name: name of the measure, such as "idle_rate.chosen".
        margin: smallest difference that matters; None if none was declared.
        code_sha256: hash of the code that computes the measure, by form of world.
        widest: largest difference that a seed can have; None if it follows from the range of the measure.
    """

    name: str
    margin: float | None
    code_sha256: dict[str, str]
    widest: float | None = None


class PlannedLook(msgspec.Struct, frozen=True, kw_only=True):
    """A planned look: a test after some of the planned seeds.

    Attributes:
        seeds: number of seeds that are played by then.
        alpha: level of a test that stands alone.
        alpha_in_family: level of the first step of Holm's correction.
    """

    seeds: int
    alpha: float
    alpha_in_family: float


class Preregistration(msgspec.Struct, frozen=True, kw_only=True):
    """The plan that is declared before the runs.

    Attributes:
        made: time of the plan, UTC.
        commit: commit of foundry's clone; None outside a clone.
        models: name of each model, and digest of its weights if its server reports one.
        seeds: all seeds in order; a look uses the first seeds.
        measures: the measures that are tested; all others are exploratory.
        tests: number of tests for each factor: its pairs of levels times the measures.
        pairs: number of pairs of levels that are tested, for each factor; empty in older plans.
        method: the test and its correction, in words.
        alpha: probability of any false finding, for each factor.
        looks: the interim looks; the last one uses all seeds.
        left_out: conditions that are not tested, with reasons.
        answers_known: number of answers that were in the cache before the plan; None if unknown.
        runs_known: names of the analysed sweeps that contained any of these runs before the plan.
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
        """Answers and runs before the plan, as a text: "already recorded before the plan: 48 answers"; "" if none."""
        if self.answers_known is None:
            answers = "an unknown number of answers"
        else:
            answers = counted(self.answers_known, "answer") if self.answers_known else ""
        parts = [answers, *(f"runs in {folder}" for folder in self.runs_known)]
        known = ", ".join(filter(None, parts))
        return f"already recorded before the plan: {known}" if known else ""

    @property
    def runs(self) -> dict[str, int]:
        """The seed of each run, by the run's id."""
        return {run: seed for condition in self.conditions for run, seed in condition.runs.items()}


def conditions_of(sweep: Sweep) -> list[PlannedCondition]:
    """Return the conditions of a sweep as a plan records them."""
    runs: list[dict[str, int]] = [{} for _ in sweep.conditions]
    for run in sweep.runs:
        runs[run.condition][run.id] = run.seed
    return [
        PlannedCondition(factors=dict(condition.factors), runs=own, **_parts(identity(condition.config)))
        for condition, own in zip(sweep.conditions, runs, strict=True)
    ]


def _parts(config: Mapping[str, Any]) -> dict[str, Part]:
    return {
        role: Part(name=str(config[role]["name"]), sha256=sha256_of(json.dumps(config[role], sort_keys=True).encode()))
        for role in ("world", "prompt", "model")
    }


def check_before_runs(folder: Path) -> None:
    """Raise an error if the folder already has a plan or a sweep."""
    if is_there(folder / PREREGISTRATION_FILE):
        raise InputError(f"'{folder}' already has a plan, which cannot change. Use another output.dir.")
    if is_sweep(folder):
        raise InputError(f"A sweep has begun in '{folder}', but a plan must precede the runs. Use another output.dir.")


def plan_sha256(folder: Path) -> str | None:
    """Return the SHA-256 of the plan in a sweep's folder, or None if it has no plan."""
    file = folder / PREREGISTRATION_FILE
    return sha256_of(file.read_bytes()) if is_there(file) else None


def holders_of(runs: Collection[str], folder: Path, sweeps: Iterable[Path]) -> list[str]:
    """Return the names of analysed sweeps that contain any of these runs; the sweep in `folder` does not count."""
    others = (sweep for sweep in sorted(sweeps) if is_sweep(sweep) and sweep.resolve() != folder.resolve())
    analysed = (other for other in others if (other / ANALYSIS).is_dir())
    return [folder.name for folder in analysed if any((folder / "runs" / run / "run.json").exists() for run in runs)]


def write_preregistration(folder: Path, plan: Preregistration) -> str:
    """Write the plan into a sweep's folder, which is created if necessary; return the file's SHA-256."""
    content = to_yaml(msgspec.to_builtins(plan)).encode()
    folder.mkdir(parents=True, exist_ok=True)
    write_atomically(folder / PREREGISTRATION_FILE, content)
    return sha256_of(content)


def preregistration_of(folder: Path) -> tuple[Preregistration, str] | None:
    """Return the plan of a sweep and the SHA-256 of its file, or None if the sweep has no plan."""
    file = folder / PREREGISTRATION_FILE
    if not is_there(file):
        return None
    content = file.read_bytes()
    try:
        return msgspec.convert(load_plain(content.decode(), file), Preregistration), sha256_of(content)
    except ValueError as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
