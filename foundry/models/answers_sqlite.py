"""Answers in a SQLite file in WAL mode, shared by the processes of one machine."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from foundry.errors import InputError, StorageError
from foundry.models.answers import Answers
from foundry.models.base import Reply

_SCHEMA = """CREATE TABLE IF NOT EXISTS answers (
    key TEXT PRIMARY KEY, model TEXT NOT NULL, reply BLOB NOT NULL, crc INTEGER NOT NULL
) WITHOUT ROWID"""
_CHUNK = 500
_LOCK_WAIT_S = 60.0
_LOCK_RETRY_S = 0.01


class SqliteAnswers(Answers):
    """Replies in a file, which may be opened by many processes at once; raises StorageError when it cannot be used."""

    def __init__(self, path: Path) -> None:
        """Open or create the file.

        Raises:
            InputError: the file is not a cache of answers, is damaged, or cannot be written.
        """
        super().__init__()
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._database = sqlite3.connect(path, timeout=_LOCK_WAIT_S, isolation_level=None)
            self._switch_to_wal()
            self._database.execute("PRAGMA synchronous=NORMAL")
            self._database.execute(_SCHEMA)
            self._database.execute("SELECT key, crc FROM answers LIMIT 1").fetchone()
        except (sqlite3.Error, OSError) as error:
            raise InputError(
                f"The answer cache '{path}' cannot be used ({error}): move it away, or name another with cache.path=..."
            ) from error

    def _switch_to_wal(self) -> None:
        """Wait for other processes that open the file at this moment, which the connection's time-out leaves out."""
        given_up = time.monotonic() + _LOCK_WAIT_S
        while True:
            try:
                self._database.execute("PRAGMA journal_mode=WAL")
                return
            except sqlite3.OperationalError as error:
                busy = error.sqlite_errorcode & 0xFF == sqlite3.SQLITE_BUSY
                if not busy or time.monotonic() > given_up:
                    raise
            time.sleep(_LOCK_RETRY_S)

    def get(self, keys: Sequence[str]) -> dict[str, Reply]:
        """Return the replies that are there, by key; damaged rows are left out."""
        found: dict[str, Reply] = {}
        for start in range(0, len(keys), _CHUNK):
            for key, blob, crc in self._rows_of(keys[start : start + _CHUNK]):
                reply = self._read(blob, crc)
                if reply is not None:
                    found[key] = reply
        return found

    def _rows_of(self, keys: Sequence[str]) -> list[Any]:
        marks = ",".join("?" * len(keys))
        query = f"SELECT key, CAST(reply AS BLOB), crc FROM answers WHERE key IN ({marks})"
        with self._using():
            return self._database.execute(query, keys).fetchall()

    def put(self, replies: Mapping[str, Reply], model: str) -> None:
        """Store replies in one transaction."""
        rows = list(self._rows(replies, model))
        with self._using():
            try:
                self._database.execute("BEGIN IMMEDIATE")
                self._database.executemany("INSERT OR REPLACE INTO answers VALUES (?, ?, ?, ?)", rows)
                self._database.execute("COMMIT")
            finally:
                if self._database.in_transaction:
                    self._database.execute("ROLLBACK")

    @contextmanager
    def _using(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise StorageError(
                f"The answer cache '{self.path}' cannot be used ({error}): make room if the disk is full, move the "
                "file away if it is damaged, then go on with foundry resume."
            ) from error

    def close(self) -> None:
        """Close the file."""
        self._database.close()
