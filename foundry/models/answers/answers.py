"""The answer cache. Runs, sweeps and processes share one cache; several machines can share one on a database server."""

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
"""A row that is written to the cache: key, name of the model, encoded reply, checksum."""
Found: TypeAlias = tuple[str, object, int, str | None]
"""A row read from the cache: key, encoded reply, checksum, and mark (None if the answer is confirmed)."""


def is_database(where: str | Path) -> bool:
    """Return whether the address of a cache names a database server, not a file."""
    return "://" in str(where)


def settled(where: str) -> str:
    """Return the address of the cache as sweeps record it: valid in any working directory, without a password."""
    if not is_database(where):
        return str(Path(where).absolute())
    check_address(where)
    return where


def check_address(url: str) -> None:
    """Raise an error for a database address of an unknown kind, or with a password in it."""
    parts = urlsplit(url)
    if parts.scheme not in ("postgresql", "postgres"):
        raise InputError(
            f"cache='{parts.scheme}://...' is not a kind of cache: name a file, or postgresql://HOST/DATABASE."
        )
    if parts.password is not None or not _SECRETS.isdisjoint(parse_qs(parts.query, keep_blank_values=True)):
        raise InputError(
            f"cache={parts.scheme}://... contains a password, and a sweep records this address. Put the password "
            "into PGPASSWORD or the password file."
        )


class CachedAnswer(msgspec.Struct, frozen=True, gc=False):
    """A cached answer.

    Attributes:
        mark: text that identifies the server's state at the time of the answer; None once the answer is confirmed.
    """

    reply: Reply
    mark: str | None = None


class Answers(ABC):
    """Stores replies under keys, which are hashes of everything that affects a reply.

    Every row has a checksum; a row that does not match its checksum counts as absent. An unconfirmed answer also has a
    mark and a number that grows with each commit. The cache remembers when answers with a mark were removed.
    """

    def __init__(self) -> None:
        self._encode = msgspec.msgpack.Encoder().encode
        self._decode = msgspec.msgpack.Decoder(Reply).decode

    @abstractmethod
    def find(self, keys: Sequence[str]) -> dict[str, CachedAnswer]:
        """Return the cached answers by key; a key without an intact answer is left out."""

    @abstractmethod
    def put(self, replies: Mapping[str, Reply], model: str, marks: Mapping[str, str] | None = None) -> None:
        """Store replies in one transaction, committed on return.

        Args:
            replies: replies by key.
            model: name of the model.
            marks: mark of each unconfirmed reply, by key. A new mark replaces an older mark of the same reply.
        """

    @abstractmethod
    def newest(self) -> int:
        """Return a number to compare with: every answer that is stored later gets a larger number."""

    @abstractmethod
    def confirm(self, marks: Collection[str], newest: int) -> None:
        """Confirm the answers with these marks (states of servers) that are numbered up to `newest`."""

    @abstractmethod
    def remove(self, marks: Collection[str]) -> int:
        """Delete the answers with these marks (states of servers), and return how many were deleted."""

    @abstractmethod
    def removals(self, marks: Collection[str]) -> int:
        """Return a counter that grows when any process deletes answers with these marks (states of servers)."""

    @abstractmethod
    def close(self) -> None:
        """Free the resources."""

    def get(self, keys: Sequence[str]) -> dict[str, Reply]:
        """Return, by key, the cached replies; replies that are not confirmed yet count too."""
        return {key: cached.reply for key, cached in self.find(keys).items()}

    def _rows(self, replies: Mapping[str, Reply], model: str) -> Iterator[Row]:
        for key, reply in replies.items():
            blob = self._encode(reply)
            yield key, model, blob, zlib.crc32(blob)

    def _intact(self, keys: Sequence[str], rows: Iterable[Found]) -> dict[str, CachedAnswer]:
        """Return the rows that were asked for and are undamaged, since a damaged file may give other rows."""
        asked, intact = frozenset(keys), {}
        for key, blob, crc, mark in rows:
            reply = self._read(blob, crc) if key in asked else None
            if reply is not None:
                intact[key] = CachedAnswer(reply, mark)
        return intact

    def _read(self, blob: object, crc: int) -> Reply | None:
        if not isinstance(blob, bytes) or zlib.crc32(blob) != crc:
            return None
        try:
            return self._decode(blob)
        except msgspec.MsgspecError:
            return None
