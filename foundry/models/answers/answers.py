"""The cache of answers, shared by runs, sweeps and processes, and through a database server by machines."""

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
"""A row to store: key, name of the model, encoded reply, checksum."""
Found: TypeAlias = tuple[str, object, int, str | None]
"""A row read from the cache: key, encoded reply, checksum, and the mark of an unconfirmed answer."""


def is_database(where: str | Path) -> bool:
    """Return whether a cache is the address of a database, not a file."""
    return "://" in str(where)


def settled(where: str) -> str:
    """Return the location of the cache in a form that may be recorded and is valid in any working directory."""
    if not is_database(where):
        return str(Path(where).absolute())
    check_address(where)
    return where


def check_address(url: str) -> None:
    """Reject a database address of an unknown kind, or with a password in it."""
    parts = urlsplit(url)
    if parts.scheme not in ("postgresql", "postgres"):
        raise InputError(
            f"cache='{parts.scheme}://...' is not a kind of cache: name a file, or postgresql://HOST/DATABASE."
        )
    if parts.password is not None or not _SECRETS.isdisjoint(parse_qs(parts.query, keep_blank_values=True)):
        raise InputError(
            f"cache={parts.scheme}://... holds a password, which would be recorded in the sweep: put it into "
            "PGPASSWORD or the password file."
        )


class Kept(msgspec.Struct, frozen=True, gc=False):
    """A cached answer.

    Attributes:
        mark: state of the server when it gave the answer; None once the answer is confirmed.
    """

    reply: Reply
    mark: str | None = None


class Answers(ABC):
    """Replies by the hash of everything that affects them.

    Every row has a checksum; a row that does not match its checksum counts as absent. The cache also stores the marks
    of unconfirmed answers, with numbers that grow with each commit, and the removals of such answers.
    """

    def __init__(self) -> None:
        self._encode = msgspec.msgpack.Encoder().encode
        self._decode = msgspec.msgpack.Decoder(Reply).decode

    @abstractmethod
    def find(self, keys: Sequence[str]) -> dict[str, Kept]:
        """Return the existing answers by key, without damaged rows."""

    @abstractmethod
    def put(self, replies: Mapping[str, Reply], model: str, marks: Mapping[str, str] | None = None) -> None:
        """Store replies in one transaction, committed on return.

        Args:
            replies: replies by key.
            model: name of the model.
            marks: state of the server, by the key of each unconfirmed reply; replaces older marks.
        """

    @abstractmethod
    def newest(self) -> int:
        """Return a number that is below the number of every later answer."""

    @abstractmethod
    def confirm(self, marks: Collection[str], newest: int) -> None:
        """Confirm answers with one of the given marks and a number up to the given one, by removing their marks."""

    @abstractmethod
    def remove(self, marks: Collection[str]) -> int:
        """Delete the answers with one of the given marks, and return how many were deleted."""

    @abstractmethod
    def removals(self, marks: Collection[str]) -> int:
        """Return a number that grows whenever any process removes answers with one of the given marks."""

    @abstractmethod
    def close(self) -> None:
        """Free the resources."""

    def get(self, keys: Sequence[str]) -> dict[str, Reply]:
        """Return the existing replies, confirmed or not, by key."""
        return {key: kept.reply for key, kept in self.find(keys).items()}

    def count(self, keys: Sequence[str]) -> int:
        """Return how many of the keys have an answer."""
        return len(self.get(keys))

    def _rows(self, replies: Mapping[str, Reply], model: str) -> Iterator[Row]:
        for key, reply in replies.items():
            blob = self._encode(reply)
            yield key, model, blob, zlib.crc32(blob)

    def _intact(self, keys: Sequence[str], rows: Iterable[Found]) -> dict[str, Kept]:
        """Return the undamaged rows that were requested; a damaged file may return others."""
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
