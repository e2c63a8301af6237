"""Answers in a SQLite file in WAL mode, shared by the processes of one machine."""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping, Sequence
from pathlib import Path

from foundry.errors import InputError
from foundry.models.answers import Answers
from foundry.models.base import Reply

_SCHEMA = """CREATE TABLE IF NOT EXISTS answers (
    key TEXT PRIMARY KEY, model TEXT NOT NULL, reply BLOB NOT NULL, crc INTEGER NOT NULL
) WITHOUT ROWID"""
_CHUNK = 500
_LOCK_WAIT_S = 60.0


class SqliteAnswers(Answers):
    """Replies in a file, which may be opened by many processes at once."""

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
            self._database.execute("PRAGMA journal_mode=WAL")
            self._database.execute("PRAGMA synchronous=NORMAL")
            self._database.execute(_SCHEMA)
            self._database.execute("SELECT key, crc FROM answers LIMIT 1").fetchone()
        except (sqlite3.Error, OSError) as error:
            raise InputError(
                f"The answer cache '{path}' cannot be used ({error}): move it away, or name another with cache.path=..."
            ) from error

    def get(self, keys: Sequence[str]) -> dict[str, Reply]:
        """Return the replies that are there, by key; damaged rows are left out."""
        found: dict[str, Reply] = {}
        for start in range(0, len(keys), _CHUNK):
            chunk = keys[start : start + _CHUNK]
            marks = ",".join("?" * len(chunk))
            rows = self._database.execute(
                f"SELECT key, CAST(reply AS BLOB), crc FROM answers WHERE key IN ({marks})", chunk
            )
            for key, blob, crc in rows:
                reply = self._read(blob, crc)
                if reply is not None:
                    found[key] = reply
        return found

    def put(self, replies: Mapping[str, Reply], model: str) -> None:
        """Store replies in one transaction."""
        rows = list(self._rows(replies, model))
        self._database.execute("BEGIN IMMEDIATE")
        try:
            self._database.executemany("INSERT OR REPLACE INTO answers VALUES (?, ?, ?, ?)", rows)
        except sqlite3.Error:
            self._database.execute("ROLLBACK")
            raise
        self._database.execute("COMMIT")

    def close(self) -> None:
        """Close the file."""
        self._database.close()
