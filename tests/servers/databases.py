"""The two kinds of answer cache, and what their tests do to them behind foundry's back."""

from __future__ import annotations

import sqlite3
from abc import ABC, abstractmethod
from pathlib import Path

from foundry.models.answers.answers import Answers
from foundry.models.answers.opening import open_answers


class Store(ABC):
    """Where answers are kept; opened as often as a test wants."""

    where: str

    def open(self) -> Answers:
        return open_answers(self.where)

    @abstractmethod
    def damage(self) -> None:
        """Change the last byte of every reply."""

    @abstractmethod
    def rows(self) -> int:
        """Return how many rows there are, as another process sees it."""


class SqliteStore(Store):
    def __init__(self, folder: Path) -> None:
        self.where = str(folder / "a.sqlite")

    def damage(self) -> None:
        with sqlite3.connect(self.where) as database:
            database.execute("UPDATE answers SET reply = substr(reply, 1, length(reply) - 1) || x'00'")
        database.close()

    def rows(self) -> int:
        database = sqlite3.connect(self.where)
        try:
            return int(database.execute("SELECT count(*) FROM answers").fetchone()[0])
        finally:
            database.close()


class PostgresStore(Store):
    def __init__(self, url: str) -> None:
        self.where = url

    def damage(self) -> None:
        import psycopg

        with psycopg.connect(self.where) as database:
            database.execute("UPDATE answers SET reply = substr(reply, 1, length(reply) - 1) || '\\x00'::bytea")

    def rows(self) -> int:
        import psycopg

        with psycopg.connect(self.where) as database:
            counted = database.execute("SELECT count(*) FROM answers").fetchone()
            return int(counted[0]) if counted else 0
