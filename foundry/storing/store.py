"""The only code that knows the layout of a sweep's folder.

The folder contains:

- sweep.yaml (the definition), multirun.yaml (Hydra's configuration), analysis/
- runs/<run-id>/{config.yaml, run.json, steps.jsonl, messages.jsonl, calls.jsonl.zst, frames/, images/}
- progress/ and locks/, while a command runs the sweep, or after that command was killed
- origins/ (calls of earlier runs), if the sweep is a probe or consists of forks
- moments.json (the moments), if the sweep is a probe
- looks.jsonl (after an analysis), notes.jsonl (the notes), preregistration.yaml (the plan)
- manifest.json, scenes.json and scenes/, if the sweep comes from a bundle

The module `foundry.storing.run_files` knows the files of a run.
"""

import contextlib
import datetime
import os
import shutil
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec

from foundry.errors import InputError, RecordError, not_found
from foundry.expansion import Condition as Condition
from foundry.expansion import Sweep
from foundry.expansion import SweepCommand as SweepCommand
from foundry.expansion import expand_ranges as expand_ranges
from foundry.expansion import is_served as is_served
from foundry.expansion import leaves as leaves
from foundry.expansion import without_servers as without_servers
from foundry.records import NOT_JSON, Call
from foundry.storing.fresh import MULTIRUN_FILE as MULTIRUN_FILE
from foundry.storing.fresh import SWEEP_FILE as SWEEP_FILE
from foundry.storing.fresh import check_own
from foundry.storing.fresh import ensure_writable as ensure_writable
from foundry.storing.fresh import fresh_folder as fresh_folder
from foundry.storing.fresh import is_sweep as is_sweep
from foundry.storing.growing import check_declared, check_digests, growth
from foundry.storing.plain import check_folder, is_there
from foundry.storing.preregistration import plan_sha256
from foundry.storing.run_files import ALWAYS_THERE as ALWAYS_THERE
from foundry.storing.run_files import ENDED_RUNS as ENDED_RUNS
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
from foundry.storing.run_files import claimed, json_file, moments_here, scene_here, sha256_of
from foundry.storing.run_files import frame_name as frame_name
from foundry.storing.run_files import last_whole_step as last_whole_step
from foundry.storing.run_files import lines_of as lines_of
from foundry.storing.run_files import read_calls as read_calls
from foundry.storing.run_files import stored_picture as stored_picture
from foundry.storing.run_files import storing as storing
from foundry.storing.run_files import write_atomically as write_atomically
from foundry.storing.sweep_file import sweep_content, sweep_from, sweep_text
from foundry.storing.sweep_file import to_yaml as to_yaml
from foundry.texts import first_of, holds_secret, without_secrets

SWEEP_LOCK = "sweep.lock"
"""The lock that a command holds while it reads and rewrites `sweep.yaml`."""
MOST_NAMED = 10
"""Maximum number of sweeps that a message names."""
WAIT_S = 30.0
"""Maximum time for which a command waits for the lock of a sweep, seconds."""
SCENES_FILE = "scenes.json"
RUN_WITH = ("cache", "runner", "record", "analyze")
"""The settings without which a recorded sweep cannot be continued."""
_LONGEST_NAMES = 60
"""Number of characters up to which the names of other sweeps are part of the name of a joint analysis."""
_ENCODE = msgspec.json.Encoder().encode


class _Report(msgspec.Struct):
    open: list[str]
    models: dict[str, dict[str, float | None]]


class SweepFolder:
    """The folder of one sweep.

    Attributes:
        sweep: the definition of the sweep: its conditions and runs.
        settings: settings of the first command (cache, runner, record, output).
        models: for each model, its name, digest and server version when the sweep began.
        plan: SHA-256 of the plan that was declared before the sweep began (`preregistration.yaml`), or None.
    """

    def __init__(
        self,
        path: Path,
        sweep: Sweep,
        settings: dict[str, Any],
        models: Sequence[dict[str, Any]],
        plan: str | None = None,
    ) -> None:
        self.path = path
        self.sweep = sweep
        self.settings = settings
        self.models = list(models)
        self.plan = plan

    @classmethod
    def open(cls, path: Path | str) -> "SweepFolder":
        """Open the folder of an existing sweep."""
        path = Path(path)
        file = path / "sweep.yaml"
        if not is_there(file) or not file.is_file():
            raise InputError(_no_sweep(path))
        check_folder(path, shallow="runs", apart="baselines")  # a run's files are checked when they are read
        try:
            content = sweep_content(file.read_text(encoding="utf-8"), file)
            return cls(path, sweep_from(content), content["settings"], content["models"], content.get("plan"))
        except (OSError, ValueError) as error:
            raise RecordError(f"{file} does not describe a sweep ({error}).") from error

    @classmethod
    def create(
        cls, path: Path, sweep: Sweep, settings: dict[str, Any], models: Sequence[dict[str, Any]]
    ) -> "SweepFolder":
        """Create the folder of a sweep, or add the missing runs to an existing sweep.

        Returns:
            The folder, with only the requested runs and settings; classes of other recorded conditions are not built.
        """
        begun = replace(sweep, history=(SweepCommand(sweep.asked, _now(), len(sweep.runs)),))
        folder = cls(path, begun, settings, models, plan_sha256(path))
        content = None if is_sweep(path) else folder._text()
        if content is not None:
            ensure_writable(path)
            check_own(path)
        with claimed(path / "locks" / SWEEP_LOCK, wait_s=WAIT_S) as mine:
            if not mine:
                raise InputError(f"Another command is adding runs to '{path}'. Try again.")
            if content is not None and not is_sweep(path):
                write_atomically(path / SWEEP_FILE, content)
                return folder
            folder = cls.open(path)
            folder._grow(sweep, models)
        folder.sweep = sweep
        return folder

    def _grow(self, asked: Sweep, models: Sequence[dict[str, Any]]) -> None:
        grown = growth(self.sweep, asked)
        check_declared(self.sweep, asked)
        check_digests(self.models, models)
        if grown.new:
            known = {model["name"] for model in self.models}
            self.sweep = grown.recorded(_now())
            self.models += [model for model in models if model["name"] not in known]
            with storing(self.path / SWEEP_FILE):
                write_atomically(self.path / SWEEP_FILE, self._text())

    def _text(self) -> bytes:
        content = sweep_text(self.sweep, self.settings, self.models, self.plan)
        _check_no_secret(content)
        return content.encode()

    def check_runnable(self) -> None:
        """Raise an error if `sweep.yaml` lacks a setting that is needed to continue the sweep."""
        for name in RUN_WITH:
            if name not in self.settings:
                raise RecordError(f"{self.path / SWEEP_FILE} lacks settings.{name}.")

    @property
    def analysis_dir(self) -> Path:
        """The folder of the analysis. A user may delete this folder, because `foundry analyze` writes it anew."""
        return self.path / "analysis"

    def analysis_dir_with(self, others: Sequence["SweepFolder"]) -> Path:
        """Return the folder of the analysis of this sweep and others; with the sweep `bar`, `analysis_with_bar`."""
        return self.path / f"analysis{_with_names(others)}"

    def export_dir(self, what: str) -> Path:
        """Return the default folder of an export to a tool such as "inspect"; a user may delete this folder."""
        return self.analysis_dir / "export" / what

    @property
    def search_file(self) -> Path:
        """Path of the index with which the viewer searches texts; a user may delete this file."""
        return self.path / "viewer" / "texts-3.sqlite"

    @property
    def report_file(self) -> Path:
        """Default path of the report."""
        return self.path / "report.html"

    def report_file_with(self, others: Sequence["SweepFolder"]) -> Path:
        """Return the default path of a report of this sweep and others."""
        return self.path / f"report{_with_names(others)}.html"

    @property
    def baselines_dir(self) -> Path:
        """The folder of the sweep that plays scripted baselines in the same worlds, with the same seeds."""
        return self.path / "baselines"

    @property
    def signatures_path(self) -> Path:
        """Path of the table with the signatures of all runs."""
        return self.analysis_dir / "signatures.csv"

    def runs(self) -> list[RunFolder]:
        """Return all runs of the sweep, including runs that have not started."""
        return self.runs_of(range(len(self.sweep.runs)))

    def runs_of(self, places: Iterable[int]) -> list[RunFolder]:
        """Return the runs with these indices in the sweep."""
        scenes = self.scenes()
        return [RunFolder(self.path, self.sweep.runs[place], self.sweep, scenes) for place in places]

    def begun(self) -> frozenset[str]:
        """Return the ids of the runs that have started, that is, that have a folder."""
        with contextlib.suppress(FileNotFoundError):
            return frozenset(os.listdir(self.path / "runs"))
        return frozenset()

    def part(self, runs: Sequence[RunFolder]) -> "SweepFolder":
        """Return the sweep with only some of its runs, to be sent to another process.

        Its path is absolute, since that process may have another working directory.
        """
        sweep = replace(self.sweep, runs=tuple(run.run for run in runs))
        return SweepFolder(self.path.absolute(), sweep, self.settings, self.models, self.plan)

    def scenes(self) -> dict[str, str]:
        """Return the files of the scenes that a bundle of this sweep contained, by their names in the sweep."""
        named = json_file(self.path / SCENES_FILE, dict[str, str]) or {}
        root = self.path.resolve()
        files = {name: (root / file).resolve() for name, file in named.items()}
        outside = [name for name, file in files.items() if not file.is_relative_to(root)]
        if outside:
            raise RecordError(f"{self.path / SCENES_FILE} is refused: '{outside[0]}' is not in the sweep's folder.")
        return {name: str(file) for name, file in files.items()}

    def sweep_here(self) -> Sweep:
        """Return the sweep, with settings that read its scenes and moments from its own folder."""
        return with_moments(self.with_scenes(self.sweep), self.path)

    def with_scenes(self, sweep: Sweep) -> Sweep:
        """Return a sweep with settings that read its scenes from the folder of this sweep."""
        scenes = self.scenes()
        placed = (
            replace(condition, config=scene_here(condition.config, scenes, self.path)) for condition in sweep.conditions
        )
        return replace(sweep, conditions=tuple(placed))

    def origin_path(self, run: str, at: int) -> Path:
        """Return the path of a file: the calls of a recorded run before the step `at`, at which its forks begin."""
        return self.path / ORIGINS / f"{run}-at{at}.jsonl.zst"

    @property
    def moments_file(self) -> Path:
        """Path of the moments of a probe; it exists only in a probe."""
        return self.path / MOMENTS_FILE

    def write_moments(self, moments: bytes, past: Mapping[str, Iterable[Call]]) -> None:
        """Write the moments of a probe, and the earlier calls of the runs from which these moments come.

        Existing files do not change.

        Args:
            moments: content of the file of moments.
            past: calls of each run, by the run's id.
        """
        for run, calls in past.items():
            path = self.path / ORIGINS / PAST.format(run)
            path.parent.mkdir(parents=True, exist_ok=True)
            if not path.exists():
                write_atomically(path, calls_bytes(calls))
        if not self.moments_file.exists():
            write_atomically(self.moments_file, moments)

    def write_multirun(self, text: str) -> None:
        """Write the configuration that Hydra composed for the first command of the sweep, unless it exists."""
        if not is_there(self.path / MULTIRUN_FILE):
            write_atomically(self.path / MULTIRUN_FILE, text.encode())

    def multirun(self) -> str:
        """Return the configuration that Hydra composed for the first command; "" if it was not stored."""
        file = self.path / MULTIRUN_FILE
        return file.read_text(encoding="utf-8") if is_there(file) else ""

    def stop_file(self, session: str) -> Path:
        """Return the path of the file that, once it exists, tells the workers of a session to stop."""
        return self.path / "progress" / f"{session}.stop"

    def ask_to_stop(self, session: str) -> None:
        """Tell the workers of a session to stop after the current step of their runs."""
        if self._session_file(session).exists():  # otherwise the session has ended
            self.stop_file(session).touch()

    def stop_asked(self, session: str) -> bool:
        """Return whether the workers of a session must stop: they were told to, or their command has ended."""
        return self.stop_file(session).exists() or not self._session_file(session).exists()

    def told_first(self, session: str) -> bool:
        """Return True to the first worker of a session that asks, which then shows a message; False to all others."""
        try:
            self.stop_file(session).with_suffix(".told").touch(exist_ok=False)
        except OSError:  # also if the session has ended
            return False
        return True

    def _session_file(self, session: str) -> Path:
        return self.path / "progress" / f"{session}.session"

    def progress_file(self, lane: str) -> Path:
        """Return the path of the progress report of a worker."""
        return self.path / "progress" / f"{lane}.json"

    def progress(self, beside: str | None = None) -> dict[str, dict[str, Any]]:
        """Return the last progress report of each worker, by its name, except of the worker `beside`."""
        reports = {}
        files: list[Path] = []
        with contextlib.suppress(FileNotFoundError):  # the session may end meanwhile
            files = sorted((self.path / "progress").glob("*.json"))
        for file in files:
            if file.stem == beside:
                continue
            with contextlib.suppress(FileNotFoundError, *NOT_JSON):
                content = file.read_bytes()
                msgspec.json.decode(content, type=_Report)
                reports[file.stem] = msgspec.json.decode(content)
        return reports

    def start_progress(self, session: str = "") -> None:
        """Begin a session and delete all progress reports; the workers of other sessions soon write theirs again."""
        begun = self._session_file(session)
        while not begun.exists():
            begun.parent.mkdir(parents=True, exist_ok=True)
            with contextlib.suppress(FileNotFoundError):  # another session just ended and removed the folder
                begun.touch()
        for file in begun.parent.glob("*.json"):
            file.unlink(missing_ok=True)

    def end_progress(self, session: str = "") -> None:
        """End a session: remove its progress files and, if all runs have ended, the locks."""
        folder = self._session_file(session).parent
        for file in folder.glob("*"):
            if file.name.removeprefix(".").startswith(session):
                file.unlink(missing_ok=True)
        with contextlib.suppress(OSError):  # it contains files of another session
            folder.rmdir()
        if all(run.ended for run in self.runs()):
            with claimed(self.path / "locks" / SWEEP_LOCK) as mine:
                if mine and all(run.ended for run in SweepFolder.open(self.path).runs()):  # the sweep may have grown
                    shutil.rmtree(self.path / "locks", ignore_errors=True)


def with_moments(sweep: Sweep, path: Path) -> Sweep:
    """Return a sweep; the worlds of a probe read their moments from the folder `path`."""
    return replace(sweep, conditions=tuple(replace(c, config=moments_here(c.config, path)) for c in sweep.conditions))


def runs_at(path: Path) -> tuple[SweepFolder, list[RunFolder]]:
    """Return a sweep and its runs, given its folder; given the folder of a run, return only this run."""
    path = path.absolute() if path.name in ("", "..") else path
    if path.parent.name != "runs":
        folder = SweepFolder.open(path)
        return folder, folder.runs()
    folder = SweepFolder.open(path.parent.parent)
    runs = {run.id: run for run in folder.runs()}
    if path.name not in runs:
        raise not_found("Run", path.name, runs, f"The runs are in '{path.parent}'.")
    return folder, [runs[path.name]]


def find_run(path: Path) -> RunFolder:
    """Return the run at a path: the path of a run's folder, or of a sweep with a single run."""
    _, runs = runs_at(path)
    if len(runs) != 1:
        named = ", ".join(run.id for run in runs[:5]) + (", ..." if len(runs) > 5 else "")
        raise InputError(f"'{path}' contains {len(runs)} runs. Name one, such as {runs[0].path}. They are {named}.")
    return runs[0]


def sweeps_in(path: Path) -> list[Path]:
    """Return the sweeps among a folder and its subfolders, newest first; a baselines folder follows its sweep."""
    places = ("", "*/", "baselines/", "*/baselines/")
    folders = {file.parent for place in places for file in path.glob(f"{place}sweep.yaml")}
    folders -= {folder for folder in folders if folder.name == "baselines" and folder != path and folder.is_symlink()}
    if not folders:
        raise InputError(_no_sweep(path))
    baselines = {folder: folder.parent for folder in folders if folder.name == "baselines" and folder.parent in folders}
    of_sweep = [folder for folder in folders if folder not in baselines]
    newest = sorted(
        of_sweep, key=lambda folder: ((folder / "sweep.yaml").stat().st_mtime_ns, str(folder)), reverse=True
    )
    return [folder for sweep in newest for folder in (sweep, sweep / "baselines") if folder in folders]


def _now() -> str:
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")


def _with_names(others: Sequence[SweepFolder]) -> str:
    names = "_".join(other.path.resolve().name for other in others)
    if len(names) > _LONGEST_NAMES:
        names = f"{len(others)}_others_{sha256_of(names.encode())[:6]}"
    return f"_with_{names}" if others else ""


def _no_sweep(path: Path) -> str:
    if not path.exists():
        return f"Folder '{path}' does not exist. Give the folder of a sweep, such as outputs/<sweep>."
    inside = sorted(entry.parent.name for entry in path.glob("*/sweep.yaml"))
    hint = f" This folder contains the sweeps {first_of(inside, MOST_NAMED)}." if inside else ""
    return f"'{path}' is not a sweep's folder: it has no sweep.yaml.{hint}"


def _check_no_secret(content: str) -> None:
    for line in content.splitlines():
        if holds_secret(line):
            shown = without_secrets(line).strip(" -")
            raise InputError(
                f"'{shown}' contains a password, which would be written into sweep.yaml. Set it in the environment, "
                "such as in PGPASSWORD, or in a file of the program that uses it."
            )
