"""The only code that knows the layout of a sweep's folder.

It contains, in outputs/<sweep>/:

- sweep.yaml, multirun.yaml, analysis/
- runs/<run-id>/{config.yaml, run.json, steps.jsonl, messages.jsonl, calls.jsonl.zst, frames/, images/}
- progress/ and locks/ while it runs or after it was killed
- origins/ in a sweep of forks or a probe, moments.json in a probe
- looks.jsonl after an analysis, notes.jsonl with notes, preregistration.yaml with a declaration
- manifest.json, scenes.json and scenes/ in an unpacked bundle

The files of a run are in `foundry.storing.run_files`.
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
from foundry.expansion import Asked as Asked
from foundry.expansion import Condition as Condition
from foundry.expansion import Sweep
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
from foundry.storing.run_files import claimed, json_file, moments_here, scene_here
from foundry.storing.run_files import frame_name as frame_name
from foundry.storing.run_files import kept_file as kept_file
from foundry.storing.run_files import last_whole_step as last_whole_step
from foundry.storing.run_files import lines_of as lines_of
from foundry.storing.run_files import read_calls as read_calls
from foundry.storing.run_files import storing as storing
from foundry.storing.run_files import write_atomically as write_atomically
from foundry.storing.sweep_file import sweep_content, sweep_from, sweep_text
from foundry.storing.sweep_file import to_yaml as to_yaml
from foundry.texts import holds_secret, without_secrets

SWEEP_LOCK = "sweep.lock"
"""Lock that is held while `sweep.yaml` is read and rewritten."""
WAIT_S = 30.0
"""Maximum time that a command waits for this lock."""
SCENES_FILE = "scenes.json"
RUN_WITH = ("cache", "runner", "record", "analyze")
"""Settings that say how a sweep is run."""
_ENCODE = msgspec.json.Encoder().encode


class _Report(msgspec.Struct):
    """The needed part of a worker's report."""

    open: list[str]
    models: dict[str, dict[str, float | None]]


class SweepFolder:
    """One sweep's folder.

    Attributes:
        settings: settings of its first run (cache, runner, record, output).
        models: name, digest and server version of each model when the sweep began.
        plan: SHA-256 of the declaration that was made before the sweep began (`preregistration.yaml`), or None.
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
        """Open an existing sweep."""
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
        """Create a sweep's folder, or continue an existing one, which grows by the missing runs.

        Returns:
            The folder with the requested runs and settings. Classes that only the recorded file names are not built.
        """
        begun = replace(sweep, history=(Asked(sweep.asked, _now(), len(sweep.runs)),))
        folder = cls(path, begun, settings, models, plan_sha256(path))
        content = None if is_sweep(path) else folder._text()
        if content is not None:
            ensure_writable(path)
            check_own(path)
        with claimed(path / "locks" / SWEEP_LOCK, wait_s=WAIT_S) as mine:
            if not mine:
                raise InputError(f"Another command is adding to '{path}'. Try again.")
            if content is not None and not is_sweep(path):
                write_atomically(path / SWEEP_FILE, content)
                return folder
            folder = cls.open(path)
            folder._grow(sweep, models)
        folder.sweep = sweep
        return folder

    def _grow(self, asked: Sweep, models: Sequence[dict[str, Any]]) -> None:
        """Add the request to the sweep and its file; without changes, the file is not rewritten."""
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
        """Return the content of `sweep.yaml`."""
        content = sweep_text(self.sweep, self.settings, self.models, self.plan)
        _check_no_secret(content)
        return content.encode()

    def check_runnable(self) -> None:
        """Check that its settings say how to run the sweep."""
        missing = [name for name in RUN_WITH if name not in self.settings]
        if missing:
            file = self.path / SWEEP_FILE
            raise RecordError(f"{file} lacks settings.{missing[0]}.")

    @property
    def analysis_dir(self) -> Path:
        """Folder of the analysis; it may be deleted."""
        return self.path / "analysis"

    def export_dir(self, what: str) -> Path:
        """Return the default folder of an export; it may be deleted."""
        return self.analysis_dir / "export" / what

    @property
    def search_file(self) -> Path:
        """Path of the viewer's index of all texts; it may be deleted."""
        return self.path / "viewer" / "texts-3.sqlite"

    @property
    def report_file(self) -> Path:
        """Default path of the report."""
        return self.path / "report.html"

    @property
    def baselines_dir(self) -> Path:
        """Folder of the sweep with scripted baselines on the same worlds and seeds."""
        return self.path / "baselines"

    @property
    def signatures_path(self) -> Path:
        """Path of the runs' signatures."""
        return self.analysis_dir / "signatures.csv"

    def runs(self) -> list[RunFolder]:
        """Return every run of the definition, started or not."""
        return self.runs_of(range(len(self.sweep.runs)))

    def runs_of(self, places: Iterable[int]) -> list[RunFolder]:
        """Return the runs with the given indices in the definition."""
        scenes = self.scenes()
        return [RunFolder(self.path, self.sweep.runs[place], self.sweep, scenes) for place in places]

    def begun(self) -> frozenset[str]:
        """Return the names of the runs' folders; all other runs have not started."""
        with contextlib.suppress(FileNotFoundError):
            return frozenset(os.listdir(self.path / "runs"))
        return frozenset()

    def part(self, runs: Sequence[RunFolder]) -> "SweepFolder":
        """Return the sweep with only some of its runs, for a process that works on these.

        Its path is absolute, since the process may start in another working directory.
        """
        sweep = replace(self.sweep, runs=tuple(run.run for run in runs))
        return SweepFolder(self.path.absolute(), sweep, self.settings, self.models, self.plan)

    def scenes(self) -> dict[str, str]:
        """Return the files of the scenes that came with the sweep in a bundle, by their names in the sweep."""
        named = json_file(self.path / SCENES_FILE, dict[str, str]) or {}
        root = self.path.resolve()
        files = {name: (root / file).resolve() for name, file in named.items()}
        outside = [name for name, file in files.items() if not file.is_relative_to(root)]
        if outside:
            raise RecordError(f"{self.path / SCENES_FILE} is refused: '{outside[0]}' is not in the sweep's folder.")
        return {name: str(file) for name, file in files.items()}

    def sweep_here(self) -> Sweep:
        """Return the sweep with the scenes and moments in its folder."""
        return with_moments(self.with_scenes(self.sweep), self.path)

    def with_scenes(self, sweep: Sweep) -> Sweep:
        """Return a sweep that uses the scenes in this sweep's folder."""
        scenes = self.scenes()
        placed = (replace(one, config=scene_here(one.config, scenes, self.path)) for one in sweep.conditions)
        return replace(sweep, conditions=tuple(placed))

    def origin_path(self, run: str, at: int) -> Path:
        """Return the path of the calls that a run shares with its forks from a given step."""
        return self.path / ORIGINS / f"{run}-at{at}.jsonl.zst"

    @property
    def moments_file(self) -> Path:
        """Path of the moments of a probe and their runs."""
        return self.path / MOMENTS_FILE

    def write_moments(self, moments: bytes, past: Mapping[str, Iterable[Call]]) -> None:
        """Write the moments of a probe and the earlier answers of their runs; existing files do not change."""
        for run, calls in past.items():
            path = self.path / ORIGINS / PAST.format(run)
            path.parent.mkdir(parents=True, exist_ok=True)
            if not path.exists():
                write_atomically(path, calls_bytes(calls))
        if not self.moments_file.exists():
            write_atomically(self.moments_file, moments)

    def write_multirun(self, text: str) -> None:
        """Write Hydra's composed sweep configuration of the first request."""
        if not is_there(self.path / MULTIRUN_FILE):
            write_atomically(self.path / MULTIRUN_FILE, text.encode())

    def multirun(self) -> str:
        """Return Hydra's composed sweep configuration; empty if it was not stored."""
        file = self.path / MULTIRUN_FILE
        return file.read_text(encoding="utf-8") if is_there(file) else ""

    def stop_file(self, session: str) -> Path:
        """Return the file whose existence asks a session's workers to stop in order."""
        return self.path / "progress" / f"{session}.stop"

    def ask_to_stop(self, session: str) -> None:
        """Ask the workers of a session to stop in order."""
        if self._session_file(session).exists():  # otherwise the session has ended
            self.stop_file(session).touch()

    def stop_asked(self, session: str) -> bool:
        """Return whether workers must stop, because they were asked to or because their command has ended."""
        return self.stop_file(session).exists() or not self._session_file(session).exists()

    def _session_file(self, session: str) -> Path:
        """Return the file that exists during a session."""
        return self.path / "progress" / f"{session}.session"

    def progress_file(self, lane: str) -> Path:
        """Return the path of a worker's progress report."""
        return self.path / "progress" / f"{lane}.json"

    def progress(self, beside: str | None = None) -> dict[str, dict[str, Any]]:
        """Return the last report of every worker, by worker, except the worker `beside`."""
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
        """Begin a session: delete the reports of the last session; a running session soon writes its reports again."""
        begun = self._session_file(session)
        while not begun.exists():
            begun.parent.mkdir(parents=True, exist_ok=True)
            with contextlib.suppress(FileNotFoundError):  # another session just ended and removed the folder
                begun.touch()
        for file in begun.parent.glob("*.json"):
            file.unlink(missing_ok=True)

    def end_progress(self, session: str = "") -> None:
        """End a session: remove its files, free locks, and remove the folder if it is then empty."""
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
    """Return a probe's sweep that uses the moments in a folder; return any other sweep unchanged."""
    return replace(sweep, conditions=tuple(replace(c, config=moments_here(c.config, path)) for c in sweep.conditions))


def runs_at(path: Path) -> tuple[SweepFolder, list[RunFolder]]:
    """Return the sweep of a path: with all its runs, or for a run's folder with this run only."""
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
    """Return the run of a path: a run's folder, or the folder of a sweep with a single run."""
    _, found = runs_at(path)
    if len(found) != 1:
        named = ", ".join(run.id for run in found[:5]) + (", ..." if len(found) > 5 else "")
        raise InputError(f"'{path}' contains {len(found)} runs. Name one, such as {found[0].path}. It has {named}.")
    return found[0]


def sweeps_in(path: Path) -> list[Path]:
    """Return the sweeps among a folder and its subfolders, newest first, each before its baselines."""
    places = ("", "*/", "baselines/", "*/baselines/")
    folders = {file.parent for place in places for file in path.glob(f"{place}sweep.yaml")}
    folders -= {one for one in folders if one.name == "baselines" and one != path and one.is_symlink()}
    if not folders:
        raise InputError(_no_sweep(path))
    baselines = {one: one.parent for one in folders if one.name == "baselines" and one.parent in folders}
    of_sweep = [one for one in folders if one not in baselines]
    newest = sorted(of_sweep, key=lambda one: ((one / "sweep.yaml").stat().st_mtime_ns, str(one)), reverse=True)
    return [one for sweep in newest for one in (sweep, sweep / "baselines") if one in folders]


def _now() -> str:
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")


def _no_sweep(path: Path) -> str:
    if not path.exists():
        return f"Folder '{path}' does not exist. Give the folder of a sweep, such as outputs/<sweep>."
    inside = sorted(entry.parent.name for entry in path.glob("*/sweep.yaml"))
    hint = f" It contains the sweeps {', '.join(inside)}." if inside else ""
    return f"'{path}' is not a sweep's folder: it has no sweep.yaml.{hint}"


def _check_no_secret(content: str) -> None:
    """Raise an error if a password would be written."""
    for line in content.splitlines():
        if holds_secret(line):
            shown = without_secrets(line).strip(" -")
            raise InputError(
                f"'{shown}' contains a password, which would be written into the sweep. Set it in the environment or "
                "in the files of the program that uses it, such as PGPASSWORD."
            )
