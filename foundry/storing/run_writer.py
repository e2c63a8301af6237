"""Writes the files of a run."""

import contextlib
import hashlib
import io
import shutil
from collections.abc import Sequence
from pathlib import Path

import msgspec
import zstandard

from foundry.errors import StorageError
from foundry.records import Call, Counts, Member, Record, RunSummary, SeenImage
from foundry.storing.run_files import count_call
from foundry.storing.store import (
    ALWAYS_THERE,
    IMAGES,
    KEPT,
    RunFolder,
    cannot_write,
    frame_name,
    storing,
    write_atomically,
)

_ENCODER = msgspec.json.Encoder()
FRAME = 1 << 22
"""Size of calls, bytes, after which their log begins a new zstandard frame; readers can skip whole frames."""


class RunWriter:
    """Writes the files of a run, except `run.json`.

    All methods raise StorageError if the system refuses to write.

    Attributes:
        counts: totals of the records and calls so far.
        members: the models of a mixed population, for `run.json`.
    """

    def __init__(self, folder: RunFolder, config_text: str) -> None:
        self.folder = folder
        self.counts = Counts()
        self.members: tuple[Member, ...] = ()
        self._files: dict[str, io.FileIO] = {}
        self._hashes: dict[str, hashlib._Hash] = {}
        self._declared: set[str] = set()
        with storing(folder.path), contextlib.ExitStack() as undo:
            undo.callback(self._close_files)
            self._begin(folder.path, config_text, undo)
            undo.pop_all()

    def _begin(self, path: Path, config_text: str, undo: contextlib.ExitStack) -> None:
        path.mkdir(parents=True, exist_ok=True)
        if path.is_symlink() or path.parent.is_symlink():  # a link's target is not the sweep's, and would be removed
            raise StorageError(f"'{path}' is refused: it is a link, not a run's folder.")
        (path / "run.json").unlink(missing_ok=True)
        for subfolder in KEPT:
            _clear(path / subfolder)
        for name in set(self.folder.streams).difference(ALWAYS_THERE):
            self.folder.stream_file(name).unlink(missing_ok=True)
        for name in ALWAYS_THERE:
            self._open(name)
        file = undo.enter_context(_fresh(self.folder.stream_file("calls")).open("wb"))
        self._calls = zstandard.ZstdCompressor(level=3).stream_writer(file)
        self._frame_size = 0
        # This file is written last: once readers see the restart, all earlier files are gone.
        write_atomically(path / "config.yaml", config_text.encode())

    def _open(self, name: str) -> None:
        self._files[name] = _fresh(self.folder.stream_file(name)).open("wb", buffering=0)
        self._hashes[name] = hashlib.sha256()

    def append(self, records: Sequence[Record]) -> None:
        """Append records to their files; each file gets a single write, so that a crash leaves complete lines."""
        by_stream: dict[str, list[Record]] = {}
        for record in records:
            by_stream.setdefault(record.stream, []).append(record)
        if fresh := by_stream.keys() - self._declared:
            self.folder.check_declared(fresh)
            self._declared |= fresh
        for name, mine in by_stream.items():
            if name != IMAGES:
                self._append(name, _ENCODER.encode_lines(mine))
        for record in records:
            record.tally(self.counts)
            if isinstance(record, SeenImage):
                self._keep(record.path, record.content)

    def _append(self, name: str, content: bytes) -> None:
        if name not in self._files:
            with storing(self.folder.stream_file(name)):
                self._open(name)
        file, left = self._files[name], memoryview(content)
        try:
            while left:  # an almost full disk takes a part of the data and raises no error
                left = left[file.write(left) :]
        except OSError as error:
            raise cannot_write(Path(file.name), error) from error
        self._hashes[name].update(content)

    def append_calls(self, calls: Sequence[Call]) -> None:
        """Append calls to the compressed log, such that all calls so far can be read after a crash."""
        try:
            self._frame_size += self._calls.write(_ENCODER.encode_lines(calls))
            is_full = self._frame_size >= FRAME
            self._calls.flush(zstandard.FLUSH_FRAME if is_full else zstandard.FLUSH_BLOCK)
        except OSError as error:
            raise cannot_write(self.folder.stream_file("calls"), error) from error
        self._frame_size = 0 if is_full else self._frame_size
        for call in calls:
            self._count(call)

    def _count(self, call: Call) -> None:
        count_call(self.counts, call)
        self.counts.model_s = (self.counts.model_s or 0.0) + call.timings.get("latency", 0.0)

    def frame(self, step: int, png: bytes) -> None:
        """Store a picture of the state after a step; step 0 is the start."""
        self._keep(frame_name(step), png)

    def _keep(self, name: str, content: bytes) -> None:
        path = self.folder.path / name
        try:
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(content)
        except OSError as error:
            raise cannot_write(path, error) from error

    def digests(self) -> dict[str, str]:
        """Return the SHA-256 of the content of each record file, by the file's name."""
        return {f"{name}.jsonl": state.hexdigest() for name, state in self._hashes.items()}

    def close(self) -> None:
        """Close the files."""
        with storing(self.folder.path):
            try:
                self._calls.close()  # type: ignore[no-untyped-call]
            finally:
                self._close_files()

    def _close_files(self) -> None:
        for file in self._files.values():
            file.close()


def _clear(folder: Path) -> None:
    if folder.is_dir() and not folder.is_symlink():
        shutil.rmtree(folder)
    else:
        folder.unlink(missing_ok=True)


def _fresh(path: Path) -> Path:
    """Remove the file or link at a path and return the path, so that a write never follows a link."""
    path.unlink(missing_ok=True)
    return path


def write_run_summary(folder: RunFolder, summary: RunSummary) -> None:
    """Write `run.json`, which marks the run as ended."""
    content = msgspec.json.format(_ENCODER.encode(summary), indent=2)
    with storing(folder.path / "run.json"):
        folder.path.mkdir(parents=True, exist_ok=True)
        write_atomically(folder.path / "run.json", content + b"\n")
