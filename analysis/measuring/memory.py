"""Caches measures, so that a second analysis measures only new or changed runs.

The cache is a SQLite file in the analysis folder. You can delete this file at any time. A copy of the file is emptied
when it is opened: its measures may come from another person, and nobody can check them.
"""

import hashlib
import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TypeAlias

import msgspec
import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]

from analysis.arrays import FloatArray
from analysis.measuring.events import Event
from foundry.own_code import own_folders, own_modules
from foundry.storing.store import RunFolder

_KEPT_EVERY = 64
"""Number of runs after which their results are committed to the database together, since each commit is slow."""
_PATIENCE_S = 0.3
"""Seconds to wait for another process; measuring a run takes less time."""
_NOWHERE = ":memory:"

_GROUPS = ("signatures", "forms")


@dataclass(frozen=True)
class RunMeasurements:
    """The results of measuring one run.

    Attributes:
        steps: its steps without texts; None if the run is incomplete.
        copies: values of measures on copies with random labels.
    """

    measures: dict[str, float]
    steps: pa.Table | None
    events: list[Event]
    copies: dict[str, FloatArray] = field(default_factory=dict)


_Kept: TypeAlias = tuple[dict[str, float], list[Event], dict[str, list[float]]]


class Memory:
    """A cache of measures and steps; the key of a run changes with its files and with the code.

    The cache only saves time. So if its file can no longer be used, because another analysis uses it or the disk is
    full, caching stops silently.
    """

    def __init__(self, connection: sqlite3.Connection) -> None:
        self._connection = connection
        self._pending = 0
        self._usable = True
        self._known = {key for (key,) in connection.execute("SELECT key FROM measured")}

    def __contains__(self, key: str) -> bool:
        return key in self._known

    def recall(self, key: str) -> RunMeasurements | None:
        """Return the results under a key, or None if there are none or they cannot be read."""
        measured = None
        with self._giving_up():
            query = "SELECT measures, steps FROM measured WHERE key = ?"
            measured = self._connection.execute(query, (key,)).fetchone() if key in self._known else None
        if measured is None:
            return None
        measures, steps = measured
        with pa.ipc.open_stream(steps) as reader:
            numbers, events, copies = msgspec.msgpack.decode(measures, type=_Kept)
            return RunMeasurements(
                numbers, reader.read_all(), events, {name: np.array(values) for name, values in copies.items()}
            )

    def keep(self, key: str, measured: RunMeasurements) -> None:
        """Store the results of a complete run."""
        assert measured.steps is not None
        if not self._usable:
            return
        sink = pa.BufferOutputStream()
        with pa.ipc.new_stream(
            sink, measured.steps.schema, options=pa.ipc.IpcWriteOptions(compression="lz4")
        ) as writer:
            writer.write_table(measured.steps)
        copies = {name: values.tolist() for name, values in measured.copies.items()}
        row = (key, msgspec.msgpack.encode((measured.measures, measured.events, copies)), sink.getvalue().to_pybytes())
        with self._giving_up():
            self._connection.execute("INSERT OR REPLACE INTO measured VALUES (?, ?, ?)", row)
            self._pending += 1
            if self._pending % _KEPT_EVERY == 0:
                self._connection.commit()

    def forget_others(self, keys: set[str]) -> None:
        """Remove the results under all other keys, such as results of older code."""
        stale = [(key,) for key in self._known - keys]
        if self._usable and stale:
            with self._giving_up():
                self._connection.executemany("DELETE FROM measured WHERE key = ?", stale)

    def close(self) -> None:
        """Write all pending results and close the file."""
        with closing(self._connection), self._giving_up():
            if self._usable:
                self._connection.commit()

    @contextmanager
    def _giving_up(self) -> Iterator[None]:
        """Run code that uses the file of the cache; after a failure, the file is not used again.

        Otherwise each further try would wait for another process that uses the file.
        """
        try:
            yield
        except sqlite3.Error:
            self._usable = False


@contextmanager
def open_memory(path: Path) -> Iterator[Memory]:
    """Open the cache; a damaged file is replaced by a new one. If no file can be used, the cache is temporary."""
    memory = _opened(path)
    try:
        yield memory
    finally:
        memory.close()


def _opened(path: Path) -> Memory:
    try:
        return _connected(path)
    except sqlite3.OperationalError:  # another process holds it, or the disk is full
        return _connected(_NOWHERE)
    except sqlite3.DatabaseError:  # damaged
        path.unlink()
        return _opened(path)


def _connected(path: Path | str) -> Memory:
    connection = sqlite3.connect(path, timeout=_PATIENCE_S)
    try:
        connection.execute("PRAGMA synchronous = OFF")  # runs lost in a crash are measured again
        connection.execute("CREATE TABLE IF NOT EXISTS measured (key TEXT PRIMARY KEY, measures BLOB, steps BLOB)")
        connection.execute("CREATE TABLE IF NOT EXISTS made_as (inode TEXT)")
        if path != _NOWHERE:
            _empty_a_copy(connection, str(os.stat(path).st_ino))
        return Memory(connection)
    except sqlite3.DatabaseError:
        connection.close()
        raise


def _empty_a_copy(connection: sqlite3.Connection, inode: str) -> None:
    """Remove all measures unless the file is still the one into which they were written."""
    if connection.execute("SELECT inode FROM made_as").fetchall() != [(inode,)]:
        connection.execute("DELETE FROM measured")
        connection.execute("DELETE FROM made_as")
        connection.execute("INSERT INTO made_as VALUES (?)", (inode,))
        connection.commit()


def key_of(folder: RunFolder, labels: str) -> str:
    """Return the key of a run: a hash of its id, form and files, of the labels of its messages, and of the code."""
    parts = "\0".join((code_version(own_folders()), labels, folder.id, folder.declared.form, folder.stamp()))
    return hashlib.blake2b(parts.encode(), digest_size=16).hexdigest()


@lru_cache(maxsize=4)
def code_version(folders: tuple[Path, ...]) -> str:
    """Return a hash of all code that affects measures: this package, and your own signatures and forms.

    Args:
        folders: your own folders; their subfolders of signatures and forms are included.
    """
    state = hashlib.blake2b(digest_size=16)
    own = [file for folder in folders for place in ("", *_GROUPS) for file in sorted((folder / place).glob("*.py"))]
    for path in [*sorted(Path(__file__).parents[1].rglob("*.py")), *own]:
        state.update(path.read_bytes())
    for module in (module for group in _GROUPS for module in own_modules(group)):
        state.update(f"{module.origin} {module.sha256}".encode())
    return state.hexdigest()
