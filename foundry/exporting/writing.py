"""Writes a sweep in the formats of other tools, without paths and servers of this machine."""

import hashlib
import importlib
import json
import shutil
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import msgspec

from foundry.errors import InputError
from foundry.records import Call, RunSummary
from foundry.storing.run_files import sha256_of
from foundry.storing.store import IMAGES, RunFolder, SweepFolder, ensure_writable, stored_picture
from foundry.trust.privacy import Scrubber
from foundry.trust.summaries import COMPLETE

_WORDS = {
    "temperature": "temperature",
    "top_p": "top_p",
    "top_k": "top_k",
    "frequency_penalty": "frequency_penalty",
    "presence_penalty": "presence_penalty",
    "stop": "stop",
    "max_tokens": "max_tokens",
    "max_completion_tokens": "max_tokens",
    "num_predict": "max_tokens",
}
_WRITERS = {"inspect": "foundry.exporting.inspect.log", "eee": "foundry.exporting.every_eval_ever.eval_records"}
"""For each export format, the module that writes it. A pip extra with the format's name installs its packages."""


@dataclass(frozen=True)
class ExportedRun:
    """An ended run, with a function that removes paths, user names and servers of this machine from its texts."""

    folder: RunFolder
    summary: RunSummary
    scrubber: Scrubber

    def calls(self) -> Iterator[Call]:
        """Yield the logged calls without paths, user names and servers of this machine."""
        for call in self.folder.calls():
            scrubbed = self.scrubber.call(call)
            self.scrubber.check(f"{self.folder.id}/calls.jsonl.zst", msgspec.json.encode(scrubbed))
            yield scrubbed

    @cached_property
    def _images(self) -> dict[str, str]:
        names = (name for name in self.folder.pictures() if name.startswith(f"{IMAGES}/"))
        return {sha256_of(stored_picture(self.folder.path, name) or b""): name for name in names}

    def image(self, sha256: str) -> tuple[str, bytes] | None:
        """Return the name and the content of an image that was sent; None if it was not recorded."""
        name = self._images.get(sha256)
        content = None if name is None else stored_picture(self.folder.path, name)
        return None if name is None or content is None else (name, content)


@dataclass(frozen=True)
class ExportedCondition:
    """A condition of a sweep with its ended runs; `asked` is the number of all its runs."""

    sweep: str
    number: int
    config: dict[str, Any]
    factors: dict[str, Any]
    asked: int
    runs: tuple[ExportedRun, ...]

    @property
    def world(self) -> str:
        """Name of the world."""
        return str(self.config["world"]["name"])

    @property
    def model(self) -> str:
        """Name of the model."""
        return str(self.config["model"]["name"])

    @property
    def prompt(self) -> str:
        """Name of the prompt."""
        return str(self.config["prompt"]["name"])

    @property
    def label(self) -> str:
        """Readable name of the condition: its world, model and prompt, and its other swept settings."""
        shown = ("world", "model", "prompt")
        further = (f"{name}={value}" for name, value in self.factors.items() if name not in shown)
        return ", ".join((self.world, self.model, self.prompt, *further))

    @property
    def complete(self) -> int:
        """Number of complete runs."""
        return sum(run.summary.status == COMPLETE for run in self.runs)

    @property
    def started(self) -> str:
        """Start of the condition's first run, ISO 8601."""
        return min(run.summary.started for run in self.runs)

    @property
    def ended(self) -> str:
        """End of the condition's last run, ISO 8601."""
        return max(run.summary.ended for run in self.runs)

    def identity(self, *of: str) -> uuid.UUID:
        """Return an identifier that only depends on the condition's configuration and the given texts."""
        return named((json.dumps(self.config, sort_keys=True, default=str), *of))

    @property
    def recorded(self) -> tuple[str, ...]:
        """The id of each run, and the time when it ended; if the run is played again, this time changes."""
        return tuple(f"{run.folder.id} {run.summary.ended}" for run in self.runs)


def named(texts: Sequence[str]) -> uuid.UUID:
    """Return an identifier that only depends on the texts, in the form of a version 4 UUID."""
    return uuid.UUID(bytes=hashlib.sha256("\0".join(texts).encode()).digest()[:16], version=4)


def conditions(folder: SweepFolder) -> list[ExportedCondition]:
    """Return the conditions of a sweep with their ended runs."""
    scrubber = Scrubber()
    name = folder.path.resolve().name
    runs: dict[int, list[RunFolder]] = {}
    for run in folder.runs():
        runs.setdefault(run.run.condition, []).append(run)
    return [_condition(name, number, folder, mine, scrubber) for number, mine in sorted(runs.items())]


def _condition(
    name: str, number: int, folder: SweepFolder, runs: Sequence[RunFolder], scrubber: Scrubber
) -> ExportedCondition:
    condition = folder.sweep.conditions[number]
    ended = ((run, run.summary()) for run in runs)
    return ExportedCondition(
        sweep=name,
        number=number,
        config=scrubber.config(condition.config),
        factors=scrubber.value(dict(condition.factors)),
        asked=len(runs),
        runs=tuple(ExportedRun(run, _scrubbed(summary, scrubber), scrubber) for run, summary in ended if summary),
    )


def _scrubbed(summary: RunSummary, scrubber: Scrubber) -> RunSummary:
    scrubbed = msgspec.convert(scrubber.value(msgspec.to_builtins(summary)), RunSummary)
    return msgspec.structs.replace(scrubbed, started=scrubbed.started or scrubbed.ended)


@dataclass(frozen=True)
class Files:
    """The written files, and notes: a line for each thing that was left out, with the reason."""

    paths: tuple[Path, ...]
    notes: tuple[str, ...] = ()


def sampling(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of a call that other tools know, by the names that these tools use."""
    given = {**parameters, **parameters.get("options", {})}
    words = {_WORDS[name]: value for name, value in given.items() if name in _WORDS and value is not None}
    if words.get("max_tokens", 1) < 1:  # Ollama's values for no limit
        del words["max_tokens"]
    return words


@dataclass(frozen=True)
class Measured:
    """A declared measure.

    Attributes:
        name: `<signature>.<measure>`.
        label: title, with the unit.
        low: least possible value; -inf if there is none.
        high: greatest possible value; inf if there is none.
        null: text with the value that is expected by chance and the policy that gives it; "" if there is none.
        better: "high" or "low" if agents should reach this end; "" for most measures, which only describe behaviour.
    """

    name: str
    label: str
    low: float
    high: float
    null: str
    better: str


@dataclass(frozen=True)
class Mean:
    """The mean of a measure over the runs of a condition.

    Attributes:
        n: number of runs with a value.
        sd: standard deviation with ddof 1; NaN with fewer than two values.
        low: lower end of the 95 % interval of the mean; NaN if undefined.
        high: upper end of this interval; NaN if undefined.
        interval: name of the method of the interval; "" if undefined.
    """

    n: int
    mean: float
    sd: float
    low: float
    high: float
    interval: str


@dataclass(frozen=True)
class Scores:
    """The declared measures of a sweep, and their values.

    Attributes:
        of_runs: value by run id and name of the measure; NaN if undefined, no value if the run lacks the measure.
        of_conditions: mean by index of the condition in the sweep, and by name of the measure.
    """

    measures: tuple[Measured, ...]
    of_runs: Mapping[str, Mapping[str, float]]
    of_conditions: Mapping[int, Mapping[str, Mean]]


Write: TypeAlias = Callable[[Sequence[ExportedCondition], Scores, Path], Files]
"""A function that writes conditions and their measures into a folder."""


@dataclass(frozen=True)
class Written:
    """The result of an export; `notes` has a line for each thing that was left out, with the reason."""

    path: Path
    files: tuple[Path, ...]
    runs: int
    notes: tuple[str, ...]


def write(what: str, folder: SweepFolder, out: Path | None, scores: Scores) -> Written:
    """Write a sweep in the format of another tool."""
    writer = _writer(what)
    every = conditions(folder)
    ended = [condition for condition in every if condition.runs]
    if not ended:
        raise InputError(
            f"No run of '{folder.path}' has ended, so nothing can be exported. Continue it with foundry resume."
        )
    path = out or folder.export_dir(what)
    if out is None:
        shutil.rmtree(path, ignore_errors=True)
    ensure_writable(path)
    if any(path.iterdir()):
        raise InputError(f"'{path}' is not empty. Name a new or an empty folder for the export.")
    files = writer(ended, scores, path)
    return Written(path, files.paths, sum(len(condition.runs) for condition in ended), (*_missing(every), *files.notes))


def _writer(what: str) -> Write:
    try:
        module = importlib.import_module(_WRITERS[what])
    except ModuleNotFoundError as error:
        name = (error.name or "").partition(".")[0]
        raise InputError(f"{name} is not installed: pip install 'foundry-worlds[{what}]'") from error
    writer: Write = module.write
    return writer


def _missing(every: Sequence[ExportedCondition]) -> list[str]:
    left = {condition.label: condition.asked - len(condition.runs) for condition in every}
    return [f"{condition}: {runs} unfinished runs are left out" for condition, runs in left.items() if runs]
