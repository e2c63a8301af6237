"""The only code that knows the layout of a sweep's folder.

outputs/<sweep>/sweep.yaml, multirun.yaml, runs/<run-id>/{config.yaml, run.json, steps.jsonl, messages.jsonl,
calls.jsonl.zst, frames/, images/}, analysis/; while it runs also progress/ and locks/.
"""

from __future__ import annotations

import contextlib
import datetime
import errno
import hashlib
import io
import os
import shutil
import threading
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec
import yaml
import zstandard
from filelock import FileLock, Timeout

from foundry.errors import InputError, RecordError
from foundry.records import Call, Counts, Record, RunSummary, SeenImage
from foundry.sweep import Condition, Run, Sweep

RECORD_STREAMS = ("steps", "messages", "episode")
ALWAYS_THERE = ("steps", "messages")
"""The record files that every run has, if only empty ones."""
_ENCODE = msgspec.json.Encoder().encode
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_Dumper: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


def to_yaml(value: Any) -> str:
    """Return the value as block-style YAML, keys in their order, non-ASCII text as it is."""
    return str(yaml.dump(value, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110))


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file so that a reader or a crash sees either all of it or none."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.{threading.get_ident()}.tmp")
    temporary.write_bytes(content)
    temporary.replace(path)


def fresh_folder(root: Path) -> Path:
    """Create and return a folder under `root` that did not exist, named by the time."""
    stamp = datetime.datetime.now().strftime("%Y-%m-%d_%H-%M-%S")
    for suffix in ("", *(f"_{number}" for number in range(2, 1000))):
        candidate = root / (stamp + suffix)
        with contextlib.suppress(FileExistsError):
            candidate.mkdir(parents=True)
            return candidate
    raise InputError(f"No fresh folder could be made under '{root}': name one with output.dir=...")


class RunFolder:
    """Where one run's files are; reads them.

    Attributes:
        id: the run's id.
        path: its folder; exists once the run was started.
        run: the run.
        factors: the swept overrides and their values for this run's condition.
    """

    def __init__(self, sweep_path: Path, run: Run, sweep: Sweep) -> None:
        self.id = run.id
        self.run = run
        self.path = sweep_path / "runs" / run.id
        self.factors = dict(sweep.conditions[run.condition].factors)
        self._sweep = sweep
        self._lock_path = sweep_path / "locks" / f"{run.id}.lock"

    def config(self) -> dict[str, Any]:
        """Return the effective configuration."""
        return self._sweep.config(self.run)

    @property
    def ended(self) -> bool:
        """Whether `run.json` is there, so that the run is complete or failed."""
        return (self.path / "run.json").exists()

    def summary(self) -> RunSummary | None:
        """Return how the run ended, or None when it has not.

        Raises:
            RecordError: `run.json` cannot be read.
        """
        try:
            content = (self.path / "run.json").read_bytes()
        except FileNotFoundError:
            return None
        try:
            return msgspec.json.decode(content, type=RunSummary)
        except msgspec.DecodeError as error:
            raise RecordError(f"{self.path / 'run.json'} cannot be read: {error}") from error

    def steps_bytes(self) -> bytes:
        """Return the raw lines of `steps.jsonl`; empty when there are none yet."""
        return self._bytes("steps.jsonl")

    def messages_bytes(self) -> bytes:
        """Return the raw lines of `messages.jsonl`; empty when there are none yet."""
        return self._bytes("messages.jsonl")

    def episode_bytes(self) -> bytes:
        """Return the raw line of `episode.jsonl`; empty when the world writes none."""
        return self._bytes("episode.jsonl")

    def calls(self) -> Iterator[Call]:
        """Yield the logged calls; a log cut by a crash yields the calls that are whole."""
        path = self.path / "calls.jsonl.zst"
        if not path.exists():
            return
        decode = msgspec.json.Decoder(Call).decode
        with path.open("rb") as file, zstandard.ZstdDecompressor().stream_reader(file) as reader:
            yield from (decode(line) for line in _whole_lines(reader))

    def _bytes(self, name: str) -> bytes:
        try:
            return (self.path / name).read_bytes()
        except FileNotFoundError:
            return b""

    def forget_failure(self) -> None:
        """Let a failed run be started again."""
        summary = self.summary()
        if summary is not None and summary.status != "complete":
            (self.path / "run.json").unlink()

    @contextlib.contextmanager
    def claim(self) -> Iterator[bool]:
        """Hold the run for this process; yields whether it could be had. The system frees it on a crash."""
        self._lock_path.parent.mkdir(parents=True, exist_ok=True)
        lock = FileLock(self._lock_path, timeout=0)
        try:
            lock.acquire()
        except Timeout:
            yield False
            return
        try:
            yield True
        finally:
            lock.release()


def _whole_lines(reader: Any) -> Iterator[bytes]:
    rest = b""
    while True:
        try:
            chunk = reader.read(1 << 20)
        except zstandard.ZstdError:
            return
        if not chunk:
            return
        *lines, rest = (rest + chunk).split(b"\n")
        yield from lines


class RunWriter:
    """Writes one run's files; `finish` writes `run.json` last."""

    def __init__(self, folder: RunFolder, config_text: str) -> None:
        self.folder = folder
        self.counts = Counts()
        path = folder.path
        path.mkdir(parents=True, exist_ok=True)
        (path / "run.json").unlink(missing_ok=True)
        for kept in ("frames", "images"):
            shutil.rmtree(path / kept, ignore_errors=True)
        (path / "episode.jsonl").unlink(missing_ok=True)
        write_atomically(path / "config.yaml", config_text.encode())
        self._files: dict[str, io.FileIO] = {}
        self._hashes: dict[str, hashlib._Hash] = {}
        for name in ALWAYS_THERE:
            self._open(name)
        self._calls_file = (path / "calls.jsonl.zst").open("wb")
        self._calls = zstandard.ZstdCompressor(level=3).stream_writer(self._calls_file)

    def _open(self, name: str) -> None:
        self._files[name] = (self.folder.path / f"{name}.jsonl").open("wb", buffering=0)
        self._hashes[name] = hashlib.sha256()

    def append(self, records: Sequence[Record]) -> None:
        """Append records to their files, one write a file, so that a crash leaves whole lines."""
        for name in RECORD_STREAMS:
            mine = [record for record in records if record.stream == name]
            if mine:
                if name not in self._files:
                    self._open(name)
                content = b"\n".join(map(_ENCODE, mine)) + b"\n"
                self._files[name].write(content)
                self._hashes[name].update(content)
        for record in records:
            record.tally(self.counts)
            if isinstance(record, SeenImage):
                self._keep(record.path, record.content)

    def append_calls(self, calls: Iterable[Call]) -> None:
        """Append calls to the compressed log and flush a block."""
        for call in calls:
            self._calls.write(_ENCODE(call) + b"\n")
            self.counts.calls += 1
            self.counts.cached += call.cached
            self.counts.retries += 0 if call.cached else len(call.attempts)
            self.counts.prompt_tokens += call.prompt_tokens or 0
            self.counts.output_tokens += call.output_tokens or 0
        self._calls.flush(zstandard.FLUSH_BLOCK)
        self._calls_file.flush()

    def frame(self, step: int, png: bytes) -> None:
        """Keep a picture of the state after `step` (0: the initial state)."""
        self._keep(f"frames/step_{step:04d}.png", png)

    def _keep(self, name: str, content: bytes) -> None:
        path = self.folder.path / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)

    def digests(self) -> dict[str, str]:
        """Return the SHA-256 of every record file as written so far."""
        return {f"{name}.jsonl": state.hexdigest() for name, state in self._hashes.items()}

    def close(self) -> None:
        """Close the files; what was appended stays."""
        self._calls.close()  # type: ignore[no-untyped-call]
        for file in self._files.values():
            file.close()


def write_run_summary(folder: RunFolder, summary: RunSummary) -> None:
    """Write `run.json` atomically."""
    folder.path.mkdir(parents=True, exist_ok=True)
    content = msgspec.json.format(_ENCODE(summary), indent=2)
    write_atomically(folder.path / "run.json", content + b"\n")


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
            RecordError: `sweep.yaml` cannot be read.
        """
        path = Path(path)
        file = path / "sweep.yaml"
        if not file.is_file():
            raise InputError(_no_sweep(path))
        try:
            content = yaml.load(file.read_text(encoding="utf-8"), Loader=_Loader)
            return cls(path, _sweep_from(content), content["settings"], content["models"])
        except (yaml.YAMLError, KeyError, TypeError, UnicodeDecodeError) as error:
            raise RecordError(f"{file} cannot be read: {type(error).__name__}: {error}") from error

    @classmethod
    def create(
        cls, path: Path, sweep: Sweep, settings: dict[str, Any], models: Sequence[dict[str, Any]]
    ) -> SweepFolder:
        """Create a sweep's folder, or continue the one that is there.

        Raises:
            InputError: the folder holds another sweep or foreign files, or cannot be written to.
        """
        if (path / "sweep.yaml").exists():
            folder = cls.open(path)
            _check_same(folder, sweep, models)
            return folder
        ensure_writable(path)
        if any(entry.name != "multirun.yaml" for entry in path.iterdir()):
            raise InputError(f"output.dir='{path}' holds files that are not a sweep's: name an empty or a new folder.")
        folder = cls(path, sweep, settings, models)
        write_atomically(path / "sweep.yaml", _sweep_text(folder).encode())
        return folder

    @property
    def analysis_dir(self) -> Path:
        """Where the analysis is written; disposable."""
        return self.path / "analysis"

    def runs(self) -> list[RunFolder]:
        """Return every run of the definition, whether started or not."""
        return [RunFolder(self.path, run, self.sweep) for run in self.sweep.runs]

    def write_multirun(self, text: str) -> None:
        """Keep Hydra's composed sweep configuration."""
        write_atomically(self.path / "multirun.yaml", text.encode())

    @property
    def stop_file(self) -> Path:
        """A file whose presence asks every worker of the sweep to stop in order."""
        return self.path / "progress" / "stop"

    def progress_file(self, lane: str) -> Path:
        """Return where a worker reports how far it is."""
        return self.path / "progress" / f"{lane}.json"

    def progress(self) -> dict[str, dict[str, Any]]:
        """Return what every worker reported last, by worker."""
        reports = {}
        for file in sorted((self.path / "progress").glob("*.json")):
            with contextlib.suppress(FileNotFoundError, msgspec.DecodeError):
                reports[file.stem] = msgspec.json.decode(file.read_bytes())
        return reports

    def start_progress(self) -> None:
        """Begin a session: forget the reports of the last one."""
        self.end_progress()
        (self.path / "progress").mkdir(parents=True, exist_ok=True)

    def end_progress(self) -> None:
        """End a session: remove the reports, and the locks that nobody holds."""
        shutil.rmtree(self.path / "progress", ignore_errors=True)
        if all(run.ended for run in self.runs()):
            shutil.rmtree(self.path / "locks", ignore_errors=True)


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


def _check_same(folder: SweepFolder, sweep: Sweep, models: Sequence[dict[str, Any]]) -> None:
    if folder.sweep.definition != sweep.definition:
        raise InputError(
            f"'{folder.path}' holds another sweep ({len(folder.sweep.runs)} runs, asked as: "
            f"{' '.join(folder.sweep.asked) or 'foundry'}): name another output.dir, or repeat its overrides."
        )
    check_digests(folder, models)


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
                f"{model['digest'][:12]} now): start a new sweep in another output.dir."
            )


def _sweep_text(folder: SweepFolder) -> str:
    sweep = folder.sweep
    head = {
        "asked": list(sweep.asked),
        "definition": sweep.definition,
        "models": folder.models,
        "settings": folder.settings,
        "conditions": [
            {
                "factors": dict(condition.factors),
                "seeds": list(condition.seeds),
                "config": dict(condition.config),
            }
            for condition in sweep.conditions
        ],
    }
    text = io.StringIO()
    text.write(to_yaml(head))
    # One JSON object a line is YAML too, and many times faster to write than nested blocks.
    text.write("runs:\n")
    for run in sweep.runs:
        line = {"id": run.id, "condition": run.condition, "seed": run.seed}
        text.write(f"- {_ENCODE(line).decode()}\n")
    return text.getvalue()


def _sweep_from(content: dict[str, Any]) -> Sweep:
    conditions = tuple(
        Condition(factors=entry["factors"], seeds=tuple(entry["seeds"]), config=entry["config"])
        for entry in content["conditions"]
    )
    runs = tuple(Run(**entry) for entry in content["runs"])
    return Sweep(asked=tuple(content["asked"]), conditions=conditions, runs=runs)
