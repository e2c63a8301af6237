"""Where answers are kept: a file, or the address of a database."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import parse_qs, urlsplit

from foundry.errors import InputError

_SECRETS = frozenset(("password", "sslpassword"))


def is_database(where: str | Path) -> bool:
    """Return whether a cache is a database's address and no file."""
    return "://" in str(where)


def settled(where: str) -> str:
    """Return where the cache is in a form that holds in any working directory and may be written down.

    Raises:
        InputError: it is an address of an unknown kind, or holds a password.
    """
    if not is_database(where):
        return str(Path(where).absolute())
    check_address(where)
    return where


def check_address(url: str) -> None:
    """Refuse the address of a database that is none, or that would give its password away.

    Raises:
        InputError: it is one of these.
    """
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
