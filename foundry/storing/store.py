"""The only code that knows the layout of a sweep's folder.

outputs/<sweep>/sweep.yaml, multirun.yaml, runs/<run-id>/{config.yaml, run.json, steps.jsonl, messages.jsonl,
calls.jsonl.zst, frames/, images/}, analysis/; while it runs also progress/ and locks/; in a sweep of forks or a probe
origins/, in a probe moments.json; in an unpacked bundle manifest.json, scenes.json and scenes/. The files of one run
are in `foundry.storing.run_files`.
"""

from __future__ import annotations

import contextlib
import datetime
import errno
import os
import shutil
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec

from foundry.errors import InputError, RecordError, not_found
from foundry.expansion import Sweep
from foundry.expansion import is_served as is_served
from foundry.expansion import without_servers as without_servers
from foundry.labels import Labels
from foundry.records import NOT_JSON, Call
from foundry.storing.plain_files import check_folder, is_there
from foundry.storing.run_files import ALWAYS_THERE as ALWAYS_THERE
from foundry.storing.run_files import IMAGES as IMAGES
from foundry.storing.run_files import KEPT as KEPT
from foundry.storing.run_files import MOMENTS_FILE as MOMENTS_FILE
from foundry.storing.run_files import ORIGINS as ORIGINS
from foundry.storing.run_files import PAST as PAST
from foundry.storing.run_files import PROBE as PROBE
from foundry.storing.run_files import RECORD_STREAMS as RECORD_STREAMS
from foundry.storing.run_files import RunFolder as RunFolder
from foundry.storing.run_files import calls_bytes as calls_bytes
from foundry.storing.run_files import cannot_write as cannot_write
from foundry.storing.run_files import frame_name as frame_name
from foundry.storing.run_files import json_file, moments_here, scene_here
from foundry.storing.run_files import kept_file as kept_file
from foundry.storing.run_files import last_whole_step as last_whole_step
from foundry.storing.run_files import lines_of as lines_of
from foundry.storing.run_files import read_calls as read_calls
from foundry.storing.run_files import storing as storing
from foundry.storing.run_files import write_atomically as write_atomically
from foundry.storing.sweep_file import sweep_content, sweep_from, sweep_text
from foundry.storing.sweep_file import to_yaml as to_yaml
from foundry.texts import holds_secret, without_secrets

SWEEP_FILE = "sweep.yaml"
ENDED_RUNS = "runs/*/run.json"
"""Matches what every run that has ended holds."""
SCENES_FILE = "scenes.json"
RUN_WITH = ("cache", "runner", "record", "analyze")
"""Settings that a sweep is run with."""
_ENCODE = msgspec.json.Encoder().encode


class _Report(msgspec.Struct):
    """What is read of the report of a worker."""

    open: list[str]
    models: dict[str, dict[str, float | None]]


def fresh_folder(root: Path) -> Path:
    """Create and return a folder under `root` that did not exist, named by the time."""
    stamp = datetime.datetime.now().strftime("%Y-%m-%d_%H-%M-%S")
    for suffix in ("", *(f"_{number}" for number in range(2, 1000))):
        candidate = root / (stamp + suffix)
        with contextlib.suppress(FileExistsError):
            candidate.mkdir(parents=True)
            return candidate
    raise InputError(f"No fresh folder could be made under '{root}': name one with output.dir=...")


class SweepFolder:
    """One sweep's folder.

    Attributes:
        path: the folder.
        sweep: the sweep as asked and as expanded.
        settings: where and how it was run first (cache, runner, record, output).
        models: name, digest and server version of each model when the sweep began.
    """

    def __init__(self, path: Path, sweep: Sweep, settings: dict[str, Any], models: Sequence[dict[str, Any]]) -> None:
        self.path = path
        self.sweep = sweep
        self.settings = settings
        self.models = list(models)

    @classmethod
    def open(cls, path: Path | str) -> SweepFolder:
        """Open an existing sweep.

        Raises:
            InputError: there is no such folder, or it holds no sweep.
            RecordError: `sweep.yaml` cannot be read, or there is something else than files and folders.
        """
        path = Path(path)
        file = path / "sweep.yaml"
        if not is_there(file) or not file.is_file():
            raise InputError(_no_sweep(path))
        check_folder(path, shallow="runs", apart="baselines")  # the files of a run are checked as they are read
        try:
            content = sweep_content(file.read_text(encoding="utf-8"), file)
            return cls(path, sweep_from(content), content["settings"], content["models"])
        except (OSError, ValueError) as error:
            raise RecordError(f"{file} cannot be read: it does not describe a sweep ({error}).") from error

    @classmethod
    def create(
        cls, path: Path, sweep: Sweep, settings: dict[str, Any], models: Sequence[dict[str, Any]]
    ) -> SweepFolder:
        """Create a sweep's folder, or continue the one that is there.

        Raises:
            InputError: the folder holds another sweep or foreign files, or cannot be written to.
        """
        if is_there(path / "sweep.yaml"):
            folder = cls.open(path)
            _check_same(folder, sweep, models)
            folder.sweep = sweep  # the same runs, built from what was asked now: a recorded file is not trusted
            return folder
        content = sweep_text(sweep, settings, models)
        _check_no_secret(content)
        ensure_writable(path)
        if any(entry.name != "multirun.yaml" for entry in path.iterdir()):
            raise InputError(f"output.dir='{path}' holds files that are not a sweep's: name an empty or a new folder.")
        folder = cls(path, sweep, settings, models)
        write_atomically(path / "sweep.yaml", content.encode())
        return folder

    def check_runnable(self) -> None:
        """Check that it says where and how it was run.

        Raises:
            RecordError: it does not, so nobody can go on with it.
        """
        missing = [name for name in RUN_WITH if name not in self.settings]
        if missing:
            file = self.path / SWEEP_FILE
            raise RecordError(f"{file} does not say how to go on: it lacks settings.{missing[0]}.")

    @property
    def analysis_dir(self) -> Path:
        """Where the analysis is written; disposable."""
        return self.path / "analysis"

    @property
    def labels_file(self) -> Path:
        """Which messages a model labelled as warnings, and which model it was."""
        return self.analysis_dir / "labels.json"

    def labels(self) -> Labels | None:
        """Return the labels of the messages, or None when no model has labelled them.

        Raises:
            RecordError: the file cannot be read.
        """
        return json_file(self.labels_file, Labels)

    def write_labels(self, labels: Labels) -> None:
        """Keep the labels of the messages."""
        ensure_writable(self.analysis_dir)
        write_atomically(self.labels_file, msgspec.json.format(_ENCODE(labels), indent=1) + b"\n")

    @property
    def report_file(self) -> Path:
        """Where the report is written unless another file is asked for; there once it is written."""
        return self.path / "report.html"

    @property
    def baselines_dir(self) -> Path:
        """A sweep's folder of its own: the scripted baselines on the same worlds and seeds."""
        return self.path / "baselines"

    @property
    def signatures_path(self) -> Path:
        """Where the signatures of the runs are, once they are measured."""
        return self.analysis_dir / "signatures.csv"

    def runs(self) -> list[RunFolder]:
        """Return every run of the definition, whether started or not."""
        return self.runs_of(range(len(self.sweep.runs)))

    def runs_of(self, places: Iterable[int]) -> list[RunFolder]:
        """Return the runs at these places of the definition."""
        scenes = self.scenes()
        return [RunFolder(self.path, self.sweep.runs[place], self.sweep, scenes) for place in places]

    def part(self, runs: Sequence[RunFolder]) -> SweepFolder:
        """Return the sweep with some of its runs alone, as small as they are; for processes that work on them."""
        sweep = replace(self.sweep, runs=tuple(run.run for run in runs))
        return SweepFolder(self.path, sweep, self.settings, self.models)

    def scenes(self) -> dict[str, str]:
        """Return the files of the scenes that came with the sweep in a bundle, by the names that it knows them by.

        Raises:
            RecordError: their list cannot be read, or names files elsewhere.
        """
        named = json_file(self.path / SCENES_FILE, dict[str, str]) or {}
        root = self.path.resolve()
        files = {name: (root / file).resolve() for name, file in named.items()}
        outside = [name for name, file in files.items() if not file.is_relative_to(root)]
        if outside:
            raise RecordError(f"{self.path / SCENES_FILE} is refused: '{outside[0]}' is not in the sweep's folder.")
        return {name: str(file) for name, file in files.items()}

    def sweep_here(self) -> Sweep:
        """Return the sweep with the scenes and moments that came with it read from its folder.

        Raises:
            RecordError: their list cannot be read, or names files elsewhere.
        """
        scenes = self.scenes()
        placed = (replace(one, config=scene_here(one.config, scenes, self.path)) for one in self.sweep.conditions)
        return with_moments(replace(self.sweep, conditions=tuple(placed)), self.path)

    def origin_path(self, run: str, at: int) -> Path:
        """Return where the calls are kept that forks of a run at a step share with it."""
        return self.path / ORIGINS / f"{run}-at{at}.jsonl.zst"

    @property
    def moments_file(self) -> Path:
        """The moments of a probe, and the runs they come from."""
        return self.path / MOMENTS_FILE

    def write_moments(self, moments: bytes, past: Mapping[str, Iterable[Call]]) -> None:
        """Keep the moments of a probe, and what was answered before them in each run; what is there stays."""
        for run, calls in past.items():
            path = self.path / ORIGINS / PAST.format(run)
            path.parent.mkdir(parents=True, exist_ok=True)
            if not path.exists():
                write_atomically(path, calls_bytes(calls))
        if not self.moments_file.exists():
            write_atomically(self.moments_file, moments)

    def write_multirun(self, text: str) -> None:
        """Keep Hydra's composed sweep configuration."""
        write_atomically(self.path / "multirun.yaml", text.encode())

    @property
    def stop_file(self) -> Path:
        """A file whose presence asks every worker of the sweep to stop in order."""
        return self.path / "progress" / "stop"

    @property
    def stop_asked(self) -> bool:
        """Whether workers must stop: they were asked to, or the command that they work for has ended its session."""
        return self.stop_file.exists() or not self.stop_file.parent.is_dir()

    def progress_file(self, lane: str) -> Path:
        """Return where a worker reports how far it is."""
        return self.path / "progress" / f"{lane}.json"

    def progress(self) -> dict[str, dict[str, Any]]:
        """Return what every worker reported last, by worker."""
        reports = {}
        files: list[Path] = []
        with contextlib.suppress(FileNotFoundError):  # the session may end while a thread looks
            files = sorted((self.path / "progress").glob("*.json"))
        for file in files:
            with contextlib.suppress(FileNotFoundError, *NOT_JSON):
                content = file.read_bytes()
                msgspec.json.decode(content, type=_Report)
                reports[file.stem] = msgspec.json.decode(content)
        return reports

    def start_progress(self) -> None:
        """Begin a session: forget the reports of the last one; those of a session that goes on are soon there again."""
        folder = self.path / "progress"
        folder.mkdir(parents=True, exist_ok=True)  # it is never missing meanwhile, which would end other sessions
        for file in filter(Path.is_file, folder.iterdir()):
            file.unlink(missing_ok=True)

    def end_progress(self, session: str = "") -> None:
        """End a session: remove the reports of its workers, all else when no other reports, and free locks.

        Args:
            session: what the names of its workers begin with.
        """
        for name in self.progress():
            if name.startswith(session):
                self.progress_file(name).unlink(missing_ok=True)
        if not self.progress():
            shutil.rmtree(self.path / "progress", ignore_errors=True)
        if all(run.ended for run in self.runs()):
            shutil.rmtree(self.path / "locks", ignore_errors=True)


def with_moments(sweep: Sweep, path: Path) -> Sweep:
    """Return a probe's sweep with its moments read from a folder; any other sweep as it is."""
    return replace(sweep, conditions=tuple(replace(c, config=moments_here(c.config, path)) for c in sweep.conditions))


def runs_at(path: Path) -> tuple[SweepFolder, list[RunFolder]]:
    """Return the sweep that a path is in, with all its runs, or with the one whose folder it is.

    Raises:
        InputError: there is no such sweep or run.
        RecordError: `sweep.yaml` cannot be read.
    """
    path = path.absolute() if path.name in ("", "..") else path
    if path.parent.name != "runs":
        folder = SweepFolder.open(path)
        return folder, folder.runs()
    folder = SweepFolder.open(path.parent.parent)
    runs = {run.id: run for run in folder.runs()}
    if path.name not in runs:
        raise not_found("Run", path.name, runs, f"They are in '{path.parent}'.")
    return folder, [runs[path.name]]


def find_run(path: Path) -> RunFolder:
    """Return the run that a path names: its own folder, or the folder of a sweep that has no other run.

    Raises:
        InputError: there is no such run; names the closest.
    """
    _, found = runs_at(path)
    if len(found) != 1:
        named = ", ".join(run.id for run in found[:5]) + (", ..." if len(found) > 5 else "")
        raise InputError(f"'{path}' holds {len(found)} runs: name one, such as {found[0].path}. It has {named}.")
    return found[0]


def sweeps_in(path: Path) -> list[Path]:
    """Return the sweeps of a folder, newest first: itself, those right below it, and their baselines.

    Raises:
        InputError: there is no such folder, or it holds no sweep.
    """
    places = ("", "*/", "baselines/", "*/baselines/")
    found = {file.parent for place in places for file in path.glob(f"{place}sweep.yaml")}
    found -= {one for one in found if one.name == "baselines" and one != path and one.is_symlink()}
    if not found:
        raise InputError(_no_sweep(path))
    return sorted(found, key=lambda one: ((one / "sweep.yaml").stat().st_mtime_ns, str(one)), reverse=True)


def ensure_writable(path: Path) -> None:
    """Create the folder and check that files can be written into it.

    Raises:
        InputError: they cannot.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / f".probe.{os.getpid()}"
        probe.write_bytes(b"")
        probe.unlink()
    except ValueError as error:  # a null character
        raise InputError(f"'{path}' cannot be the name of a folder ({error}): choose another.") from error
    except OSError as error:
        cause = errno.errorcode.get(error.errno or 0, "error")
        raise InputError(
            f"'{path}' cannot be written to ({cause}: {error.strerror}): choose another folder."
        ) from error


def _no_sweep(path: Path) -> str:
    if not path.exists():
        return f"Folder '{path}' does not exist: give the folder of a sweep, such as outputs/<sweep>."
    inside = sorted(entry.parent.name for entry in path.glob("*/sweep.yaml"))
    hint = f" It holds the sweeps: {', '.join(inside)}." if inside else ""
    return f"'{path}' is not a sweep's folder: it has no sweep.yaml.{hint}"


def _check_no_secret(content: str) -> None:
    """Refuse to write down a password.

    Raises:
        InputError: an address holds one.
    """
    for line in content.splitlines():
        if holds_secret(line):
            shown = without_secrets(line).strip(" -")
            raise InputError(
                f"'{shown}' holds a password, which would be written into the sweep: give it "
                "by the environment or the files that are read where it is used, such as PGPASSWORD."
            )


def _check_same(folder: SweepFolder, sweep: Sweep, models: Sequence[dict[str, Any]]) -> None:
    if folder.sweep.definition != sweep.definition:
        asked = without_secrets(" ".join(folder.sweep.asked)) or "foundry"
        raise InputError(
            f"'{folder.path}' holds another sweep ({len(folder.sweep.runs)} runs, asked as: {asked}): name another "
            "output.dir, or repeat its overrides."
        )
    check_declared(folder, sweep)
    check_digests(folder, models)


def check_declared(folder: SweepFolder, now: Sweep) -> None:
    """Refuse to continue a sweep whose worlds by now say other things of their records.

    Args:
        folder: the sweep; what was recorded by 0.1 says nothing.
        now: the same runs, declared by the worlds as they are now.

    Raises:
        InputError: one does.
    """
    declared = {run.id: now.conditions[run.condition].declared for run in now.runs}
    for number, run in {run.condition: run.id for run in folder.sweep.runs}.items():
        then = folder.sweep.conditions[number]
        if then.declared not in (None, declared[run]):
            raise InputError(
                f"World '{then.config['world']['name']}' says other things of its records than when this sweep began: "
                "put its first version back and say it again, or start a new sweep in another output.dir."
            )


def check_digests(folder: SweepFolder, models: Sequence[dict[str, Any]]) -> None:
    """Refuse to continue a sweep with other weights under the same name.

    Raises:
        InputError: a model's digest is not the one the sweep began with.
    """
    before = {model["name"]: model["digest"] for model in folder.models}
    for model in models:
        known = before.get(model["name"])
        if known is not None and model["digest"] is not None and known != model["digest"]:
            raise InputError(
                f"Model '{model['name']}' changed since this sweep began (digest {known[:12]} then, "
                f"{model['digest'][:12]} now): put the first one back and say it again, or start a new sweep in "
                "another output.dir."
            )
