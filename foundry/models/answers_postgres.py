"""Answers in a PostgreSQL database, shared by machines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from foundry.errors import InputError, StorageError
from foundry.models.answers import Answers, check_address
from foundry.models.base import Reply

_SCHEMA = """CREATE TABLE IF NOT EXISTS answers (
    key TEXT PRIMARY KEY, model TEXT NOT NULL, reply BYTEA NOT NULL, crc BIGINT NOT NULL
)"""
_CREATION_LOCK = 0x666F756E
"""Two sessions that create a table at once may both fail, whatever IF NOT EXISTS says; so they take turns."""
_GET = "SELECT key, reply, crc FROM answers WHERE key = ANY(%s)"
_PUT = """INSERT INTO answers VALUES (%s, %s, %s, %s)
ON CONFLICT (key) DO UPDATE SET model = EXCLUDED.model, reply = EXCLUDED.reply, crc = EXCLUDED.crc"""
_INSTALL = "pip install 'foundry-worlds[postgres]'"
_RESTART_S = 60
"""How long a server may be away, as for its restart, before the sweep ends."""


class PostgresAnswers(Answers):
    """Replies in a table `answers`. The password comes from PGPASSWORD or from the password file, never from the URL.

    A connection that the server closed is opened anew.
    """

    def __init__(self, url: str) -> None:
        """Connect, and create the table where it is missing.

        Raises:
            InputError: the URL holds a password, the driver is missing, or the database cannot be used.
        """
        super().__init__()
        check_address(url)
        try:
            import psycopg
            import tenacity
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
                self._connection.execute(_SCHEMA)
        except psycopg.Error as error:
            cause = " ".join(str(error).split())
            raise InputError(f"The answer cache '{url}' cannot be used ({cause}).") from error

    def _connect(self) -> Any:
        return self._driver.connect(self.url, autocommit=True, connect_timeout=10)

    def get(self, keys: Sequence[str]) -> dict[str, Reply]:
        """Return the replies that are there, by key; damaged rows are left out."""
        rows = self._again(lambda connection: connection.execute(_GET, (list(keys),)).fetchall())
        read = ((key, self._read(bytes(blob), crc)) for key, blob, crc in rows)
        return {key: reply for key, reply in read if reply is not None}

    def put(self, replies: Mapping[str, Reply], model: str) -> None:
        """Store replies in one transaction, by key, so that two writers cannot block each other."""
        rows = sorted(self._rows(replies, model))
        self._again(lambda connection: _insert(connection, rows))

    def _again(self, work: Any) -> Any:
        """Do the work, again over a new connection if the old one is gone: all of it can be repeated.

        Raises:
            StorageError: the server cannot be reached, or refuses the work.
        """
        try:
            return self._until_back(self._once, work)
        except self._driver.Error as error:
            cause = " ".join(str(error).split())
            raise StorageError(f"The answer cache '{self.url}' cannot be used any more ({cause}).") from error

    def _once(self, work: Any) -> Any:
        if self._connection.closed:
            self._connection = self._connect()
        return work(self._connection)

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()


def _insert(connection: Any, rows: Sequence[tuple[Any, ...]]) -> None:
    with connection.transaction(), connection.cursor() as cursor:
        cursor.executemany(_PUT, rows)
