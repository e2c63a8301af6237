"""Answers in a PostgreSQL database, shared by machines."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import tenacity

from foundry.errors import InputError, StorageError
from foundry.models.answers.answers import Answers, CachedAnswer, Row, check_address
from foundry.models.base import Reply
from foundry.texts import one_line

_SCHEMA = (
    """CREATE TABLE IF NOT EXISTS answers (
    key TEXT PRIMARY KEY, model TEXT NOT NULL, reply BYTEA NOT NULL, crc BIGINT NOT NULL
)""",
    """CREATE TABLE IF NOT EXISTS unconfirmed (
    number BIGSERIAL PRIMARY KEY, key TEXT NOT NULL UNIQUE, mark TEXT NOT NULL
)""",
    "CREATE TABLE IF NOT EXISTS removals (number BIGSERIAL PRIMARY KEY, mark TEXT NOT NULL)",
)
"""The tables. When an older database is opened, missing tables are added, and the answers in it count as confirmed."""
_CREATION_LOCK = 0x666F756E
"""Lock while tables are created: two sessions that create tables at once may both fail, even with IF NOT EXISTS."""
_FIND = "SELECT key, reply, crc, mark FROM answers LEFT JOIN unconfirmed USING (key) WHERE key = ANY(%s)"
_PUT = """INSERT INTO answers VALUES (%s, %s, %s, %s)
ON CONFLICT (key) DO UPDATE SET model = EXCLUDED.model, reply = EXCLUDED.reply, crc = EXCLUDED.crc"""
_MARK = """INSERT INTO unconfirmed (key, mark) VALUES (%s, %s)
ON CONFLICT (key) DO UPDATE SET number = EXCLUDED.number, mark = EXCLUDED.mark"""
_REMOVE = """WITH gone AS (DELETE FROM unconfirmed WHERE mark = ANY(%s) RETURNING key)
DELETE FROM answers WHERE key IN (SELECT key FROM gone)"""
_INSTALL = "pip install 'foundry-worlds[postgres]'"
_RESTART_S = 60
"""Longest time for which the database server may be unreachable, seconds; after it, the sweep ends with an error."""


class PostgresAnswers(Answers):
    """A cache in a PostgreSQL database. The password comes from PGPASSWORD or the password file, never from the URL.

    If the server closes the connection, a new one is opened.
    """

    def __init__(self, url: str) -> None:
        """Connect, and create the table if it is missing."""
        super().__init__()
        check_address(url)
        try:
            import psycopg
        except ImportError as error:
            raise InputError(f"cache='{url}' needs a driver that is not installed: {_INSTALL}") from error
        self.url = url
        self._driver = psycopg
        self._until_back = tenacity.Retrying(
            retry=tenacity.retry_if_exception_type(psycopg.OperationalError),
            stop=tenacity.stop_after_delay(_RESTART_S),
            wait=tenacity.wait_exponential(multiplier=0.1, max=2),
            reraise=True,
        )
        try:
            self._connection = self._connect()
            with self._connection.transaction():
                self._connection.execute("SELECT pg_advisory_xact_lock(%s)", (_CREATION_LOCK,))
                for table in _SCHEMA:
                    self._connection.execute(table)
        except psycopg.Error as error:
            cause = one_line(error)
            raise InputError(f"The answer cache '{url}' cannot be used ({cause}).") from error

    def _connect(self) -> Any:
        return self._driver.connect(self.url, autocommit=True, connect_timeout=10)

    def find(self, keys: Sequence[str]) -> dict[str, CachedAnswer]:
        """Return the cached answers by key; a key without an intact answer is left out."""
        rows = self._again(lambda connection: connection.execute(_FIND, (list(keys),)).fetchall())
        return self._intact(keys, ((key, bytes(blob), crc, mark) for key, blob, crc, mark in rows))

    def put(self, replies: Mapping[str, Reply], model: str, marks: Mapping[str, str] | None = None) -> None:
        """Store replies in one transaction, in the order of keys, so that two writers cannot block each other."""
        rows, marked = sorted(self._rows(replies, model)), sorted((marks or {}).items())
        self._again(lambda connection: _insert(connection, rows, marked))

    def newest(self) -> int:
        """Return the number of the newest unconfirmed answer, or 0.

        An answer with a smaller number that is not committed yet also counts as stored earlier.
        """
        return self._number("SELECT coalesce(max(number), 0) FROM unconfirmed")

    def confirm(self, marks: Collection[str], newest: int) -> None:
        """Confirm the answers with these marks (states of servers) that are numbered up to `newest`."""
        delete = "DELETE FROM unconfirmed WHERE mark = ANY(%s) AND number <= %s"
        self._again(lambda connection: connection.execute(delete, (list(marks), newest)))

    def remove(self, marks: Collection[str]) -> int:
        """Delete the answers with these marks (states of servers), and return how many were deleted."""
        removed: int = self._again(lambda connection: _delete(connection, list(marks)))
        return removed

    def removals(self, marks: Collection[str]) -> int:
        """Return a counter that grows when any process deletes answers with these marks (states of servers)."""
        return self._number("SELECT coalesce(max(number), 0) FROM removals WHERE mark = ANY(%s)", list(marks))

    def _number(self, query: str, *parameters: Any) -> int:
        return int(self._again(lambda connection: connection.execute(query, parameters).fetchone()[0]))

    def _again(self, work: Any) -> Any:
        """Call `work`. If the connection is lost, call `work` again with a new one; a second call does no harm."""
        try:
            return self._until_back(self._once, work)
        except self._driver.Error as error:
            cause = one_line(error)
            raise StorageError(f"The answer cache '{self.url}' can no longer be used ({cause}).") from error

    def _once(self, work: Any) -> Any:
        if self._connection.closed:
            self._connection = self._connect()
        return work(self._connection)

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()


def _insert(connection: Any, rows: Sequence[Row], marked: Sequence[tuple[str, str]]) -> None:
    with connection.transaction(), connection.cursor() as cursor:
        cursor.executemany(_PUT, rows)
        unmarked = sorted({row[0] for row in rows} - {key for key, _ in marked})
        if unmarked:
            cursor.execute("DELETE FROM unconfirmed WHERE key = ANY(%s)", (unmarked,))
        cursor.executemany(_MARK, marked)


def _delete(connection: Any, marks: list[str]) -> int:
    with connection.transaction():
        removed = int(connection.execute(_REMOVE, (marks,)).rowcount)
        if removed:
            connection.execute("INSERT INTO removals (mark) SELECT unnest(%s::text[])", (marks,))
    return removed
