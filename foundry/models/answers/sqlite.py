"""Answers in a SQLite file in WAL mode, shared by the processes of one machine."""

import sqlite3
import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from foundry.errors import InputError, StorageError
from foundry.models.answers.answers import Answers, CachedAnswer
from foundry.models.base import Reply

_SCHEMA = (
    """CREATE TABLE IF NOT EXISTS answers (
    key TEXT PRIMARY KEY, model TEXT NOT NULL, reply BLOB NOT NULL, crc INTEGER NOT NULL
) WITHOUT ROWID""",
    """CREATE TABLE IF NOT EXISTS unconfirmed (
    key TEXT PRIMARY KEY, mark TEXT NOT NULL, number INTEGER NOT NULL
) WITHOUT ROWID""",
    "CREATE TABLE IF NOT EXISTS commits (only INTEGER PRIMARY KEY, number INTEGER NOT NULL)",
    "CREATE TABLE IF NOT EXISTS removals (number INTEGER PRIMARY KEY AUTOINCREMENT, mark TEXT NOT NULL)",
)
"""The tables. When an older file is opened, missing tables are added, and the answers in it count as confirmed."""
_FIND = """SELECT answers.key, CAST(reply AS BLOB), crc, mark FROM answers
LEFT JOIN unconfirmed ON unconfirmed.key = answers.key WHERE answers.key IN"""
_COUNT = """INSERT INTO commits VALUES (1, 1)
ON CONFLICT (only) DO UPDATE SET number = number + 1 RETURNING number"""
_CHUNK = 500
_LOCK_WAIT_S = 60.0
_LOCK_RETRY_S = 0.01


class SqliteAnswers(Answers):
    """A cache in a file, which many processes may open; raises StorageError if the file cannot be used."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._database = sqlite3.connect(path, timeout=_LOCK_WAIT_S, isolation_level=None)
            self._switch_to_wal()
            self._database.execute("PRAGMA synchronous=NORMAL")
            for table in _SCHEMA:
                self._database.execute(table)
            self._database.execute("SELECT key, crc FROM answers LIMIT 1").fetchone()
        except (sqlite3.Error, OSError) as error:
            raise InputError(
                f"The answer cache '{path}' cannot be used ({error}): move it away, or set another cache.path=..."
            ) from error

    def _switch_to_wal(self) -> None:
        """Switch to WAL mode, and wait while another process switches; the connection's timeout does not cover this."""
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

    def find(self, keys: Sequence[str]) -> dict[str, CachedAnswer]:
        """Return the cached answers by key; a key without an intact answer is left out."""
        answers: dict[str, CachedAnswer] = {}
        for start in range(0, len(keys), _CHUNK):
            chunk = keys[start : start + _CHUNK]
            answers |= self._intact(chunk, self._rows_of(f"{_FIND} {_places(chunk)}", chunk))
        return answers

    def put(self, replies: Mapping[str, Reply], model: str, marks: Mapping[str, str] | None = None) -> None:
        """Store replies in one transaction."""
        rows, marks = list(self._rows(replies, model)), marks or {}
        with self._changing() as database:
            database.executemany("INSERT OR REPLACE INTO answers VALUES (?, ?, ?, ?)", rows)
            number = database.execute(_COUNT).fetchone()[0]
            marked = [(key, mark, number) for key, mark in marks.items()]
            database.executemany("INSERT OR REPLACE INTO unconfirmed VALUES (?, ?, ?)", marked)
            unmarked = [(key,) for key in replies if key not in marks]
            database.executemany("DELETE FROM unconfirmed WHERE key = ?", unmarked)

    def newest(self) -> int:
        """Return the number of the latest commit to this database; each commit gets a larger number."""
        return int(self._rows_of("SELECT coalesce(max(number), 0) FROM commits")[0][0])

    def confirm(self, marks: Collection[str], newest: int) -> None:
        """Confirm the answers with these marks (states of servers) that are numbered up to `newest`."""
        with self._changing() as database:
            delete = f"DELETE FROM unconfirmed WHERE mark IN {_places(marks)} AND number <= ?"
            database.execute(delete, (*marks, newest))

    def remove(self, marks: Collection[str]) -> int:
        """Delete the answers with these marks (states of servers), and return how many were deleted."""
        marked = f"unconfirmed WHERE mark IN {_places(marks)}"
        with self._changing() as database:
            delete = f"DELETE FROM answers WHERE key IN (SELECT key FROM {marked})"
            removed = database.execute(delete, tuple(marks)).rowcount
            if removed:
                database.execute(f"DELETE FROM {marked}", tuple(marks))
                database.executemany("INSERT INTO removals (mark) VALUES (?)", [(mark,) for mark in marks])
        return removed

    def removals(self, marks: Collection[str]) -> int:
        """Return a counter that grows when any process deletes answers with these marks (states of servers)."""
        query = f"SELECT coalesce(max(number), 0) FROM removals WHERE mark IN {_places(marks)}"
        return int(self._rows_of(query, tuple(marks))[0][0])

    def _rows_of(self, query: str, parameters: Sequence[str] = ()) -> list[Any]:
        try:
            return self._database.execute(query, parameters).fetchall()
        except sqlite3.Error as error:
            raise self._unusable(error) from error

    @contextmanager
    def _changing(self) -> Iterator[sqlite3.Connection]:
        """Open a transaction; at the end it is committed, or rolled back after an error."""
        try:
            try:
                self._database.execute("BEGIN IMMEDIATE")
                yield self._database
                self._database.execute("COMMIT")
            finally:
                if self._database.in_transaction:
                    self._database.execute("ROLLBACK")
        except sqlite3.Error as error:
            raise self._unusable(error) from error

    def _unusable(self, error: sqlite3.Error) -> StorageError:
        return StorageError(
            f"The answer cache '{self.path}' cannot be used ({error}). Free disk space if it is full, or move the "
            "file away if it is damaged; then continue with foundry resume."
        )

    def close(self) -> None:
        """Close the file."""
        self._database.close()


def _places(values: Collection[str]) -> str:
    return f"({','.join('?' * len(values))})"
