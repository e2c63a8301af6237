"""The answers that were given before, shared by runs, sweeps, processes and, in a database server, by machines."""

import zlib
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias
from urllib.parse import parse_qs, urlsplit

import msgspec

from foundry.errors import InputError
from foundry.models.base import Reply

_SECRETS = frozenset(("password", "sslpassword"))
Row: TypeAlias = tuple[str, str, bytes, int]
"""Key, name of the model, encoded reply, checksum."""
Found: TypeAlias = tuple[str, object, int, str | None]
"""Key, encoded reply, checksum, and what the server was when it gave an answer that is not confirmed."""


def is_database(where: str | Path) -> bool:
    """Return whether a cache is a database's address and no file."""
    return "://" in str(where)


def settled(where: str) -> str:
    """Return where the cache is in a form that holds in any working directory and may be written down."""
    if not is_database(where):
        return str(Path(where).absolute())
    check_address(where)
    return where


def check_address(url: str) -> None:
    """Refuse the address of a database that is none, or that would give its password away."""
    parts = urlsplit(url)
    if parts.scheme not in ("postgresql", "postgres"):
        raise InputError(
            f"cache='{parts.scheme}://...' is no kind of cache: name a file, or postgresql://HOST/DATABASE."
        )
    if parts.password is not None or not _SECRETS.isdisjoint(parse_qs(parts.query, keep_blank_values=True)):
        raise InputError(
            f"cache={parts.scheme}://... holds a password, which would be written into the sweep: "
            "put it into PGPASSWORD or the password file instead."
        )


class Kept(msgspec.Struct, frozen=True, gc=False):
    """An answer as it is kept.

    Attributes:
        mark: what its server was when it gave the answer, until that is confirmed; None once it is.
    """

    reply: Reply
    mark: str | None = None


class Answers(ABC):
    """Replies by the hash of everything that decides them.

    Every row carries a checksum; a row that does not match it is as good as absent. Beside the rows stand the marks of
    those that are not confirmed, with numbers that grow from commit to commit, and the removals of such rows.
    """

    def __init__(self) -> None:
        self._encode = msgspec.msgpack.Encoder().encode
        self._decode = msgspec.msgpack.Decoder(Reply).decode

    @abstractmethod
    def find(self, keys: Sequence[str]) -> dict[str, Kept]:
        """Return the answers that are there, by key; damaged rows are left out."""

    @abstractmethod
    def put(self, replies: Mapping[str, Reply], model: str, marks: Mapping[str, str] | None = None) -> None:
        """Store replies in one transaction; they are committed when this returns.

        Args:
            replies: by key.
            model: name of the model.
            marks: what the server is, by the key of each reply that waits for a confirmation; replaces older marks.
        """

    @abstractmethod
    def newest(self) -> int:
        """Return a number that every answer that comes in from now on exceeds."""

    @abstractmethod
    def confirm(self, marks: Collection[str], newest: int) -> None:
        """Take the marks from the answers that have one of these and were there when this number was the newest."""

    @abstractmethod
    def remove(self, marks: Collection[str]) -> int:
        """Delete the answers that have one of these marks; returns how many there were."""

    @abstractmethod
    def removals(self, marks: Collection[str]) -> int:
        """Return a number that grows whenever answers with one of these marks are removed, by whomever."""

    @abstractmethod
    def close(self) -> None:
        """Free what is held."""

    def get(self, keys: Sequence[str]) -> dict[str, Reply]:
        """Return the replies that are there, confirmed or not, by key."""
        return {key: kept.reply for key, kept in self.find(keys).items()}

    def count(self, keys: Sequence[str]) -> int:
        """Return how many of the keys have an answer."""
        return len(self.get(keys))

    def _rows(self, replies: Mapping[str, Reply], model: str) -> Iterator[Row]:
        for key, reply in replies.items():
            blob = self._encode(reply)
            yield key, model, blob, zlib.crc32(blob)

    def _intact(self, keys: Sequence[str], rows: Iterable[Found]) -> dict[str, Kept]:
        """Return the rows that are whole; a damaged file may hand out rows that nobody asked for."""
        asked, found = frozenset(keys), {}
        for key, blob, crc, mark in rows:
            reply = self._read(blob, crc) if key in asked else None
            if reply is not None:
                found[key] = Kept(reply, mark)
        return found

    def _read(self, blob: object, crc: int) -> Reply | None:
        if not isinstance(blob, bytes) or zlib.crc32(blob) != crc:
            return None
        try:
            return self._decode(blob)
        except msgspec.MsgspecError:
            return None
