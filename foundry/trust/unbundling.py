"""Unpacks a bundle of unknown origin, which may only contain plain files with plain names and the declared sizes."""

import hashlib
import shutil
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import zstandard

from foundry.errors import InputError
from foundry.storing.store import ensure_writable
from foundry.trust.manifest import LARGEST_BYTES, NAME, BundledFile, Manifest, read_manifest

GIB = 1 << 30
LARGEST_WINDOW = 1 << 27
"""Memory that decompression may use, bytes."""
_CHUNK = 1 << 20
_BLOCK = tarfile.BLOCKSIZE


class _Members:
    """Reads a tar archive member by member. Every archive member must be a plain file without extended headers."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream

    def next(self) -> tarfile.TarInfo | None:
        """Return the header of the next member, or None at the end of the archive."""
        block = self._read(_BLOCK)
        if block == b"\0" * _BLOCK:
            return None
        try:
            info = tarfile.TarInfo.frombuf(block, "utf-8", "strict")
        except (tarfile.HeaderError, UnicodeDecodeError) as error:
            raise InputError(f"The bundle is refused: it holds no readable archive ({error}).") from error
        if info.type != tarfile.REGTYPE or info.linkname:
            raise InputError(f"The bundle is refused: {info.name!r} is not a plain file.")
        return info

    def chunks(self, size: int) -> Iterator[bytes]:
        left = size
        while left:
            chunk = self._read(min(left, _CHUNK))
            left -= len(chunk)
            yield chunk
        self._read(-size % _BLOCK)

    def check_end(self) -> None:
        """Raise an error if anything follows the two empty blocks that end an archive."""
        if self._read(_BLOCK) != b"\0" * _BLOCK or self._stream.read(1):
            raise InputError("The bundle is refused: something follows the end of its archive.")

    def _read(self, size: int) -> bytes:
        content = b""
        while len(content) < size:
            more = self._stream.read(size - len(content))
            if not more:
                raise InputError("The bundle is refused: it ends too early.")
            content += more
        return content


def unpack_bundle(bundle: Path, target: Path, *, limit: int = 16 * GIB) -> Manifest:
    """Unpack a bundle into a new folder, which is removed after an error; `limit` is the maximum size, bytes."""
    if not bundle.is_file():
        raise InputError(f"Bundle '{bundle}' does not exist.")
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        raise InputError(f"'{target}' is not empty. Name a new or an empty folder.")
    ensure_writable(target.parent)
    with tempfile.TemporaryDirectory(prefix=".unbundle-", dir=target.parent) as name:
        fresh = Path(name) / "sweep"
        fresh.mkdir()
        with _opened(bundle) as members:
            manifest = _unpack(members, fresh, limit)
        if target.exists():
            target.rmdir()
        fresh.rename(target)
    return manifest


@contextmanager
def _opened(bundle: Path) -> Iterator[_Members]:
    try:
        with (
            bundle.open("rb") as file,
            zstandard.ZstdDecompressor(max_window_size=LARGEST_WINDOW).stream_reader(file) as stream,
        ):
            yield _Members(stream)
    except zstandard.ZstdError as error:
        raise InputError(
            f"'{bundle}' is refused: it cannot be decompressed ({error}). "
            "Name the .tar.zst file that 'foundry bundle' wrote."
        ) from error


def _unpack(members: _Members, folder: Path, limit: int) -> Manifest:
    content = _manifest(members)
    manifest = read_manifest(content)
    (folder / NAME).write_bytes(content)
    total = sum(file.size for file in manifest.files)
    free = shutil.disk_usage(folder).free
    if total > min(limit, free):
        raise InputError(
            f"The bundle is refused: it unpacks to {total / GIB:.2f} GiB, but only {min(limit, free) / GIB:.2f} GiB "
            "are allowed and free. Free some space, or raise --limit."
        )
    for file in manifest.files:
        _unpack_file(members, folder, file)
    extra = members.next()
    if extra is not None:
        raise InputError(f"The bundle is refused: {extra.name!r} is not in its manifest.")
    members.check_end()
    return manifest


def _manifest(members: _Members) -> bytes:
    first = members.next()
    if first is None or first.name != NAME:
        raise InputError(f"The bundle is refused: its first file is not {NAME}.")
    if first.size > LARGEST_BYTES:
        raise InputError(f"The bundle is refused: its manifest has {first.size:,} bytes, more than {LARGEST_BYTES:,}.")
    return b"".join(members.chunks(first.size))


def _unpack_file(members: _Members, folder: Path, file: BundledFile) -> None:
    info = members.next()
    if info is None or info.name != file.path:
        there = "its end" if info is None else repr(info.name)
        raise InputError(f"The bundle is refused: instead of {file.path!r} it has {there}.")
    if info.size != file.size:
        raise InputError(
            f"The bundle is refused: {file.path!r} has {info.size:,} bytes instead of the declared {file.size:,}."
        )
    target = folder / file.path
    target.parent.mkdir(parents=True, exist_ok=True)
    digest = hashlib.sha256()
    with target.open("xb") as out:
        for chunk in members.chunks(file.size):
            digest.update(chunk)
            out.write(chunk)
    if digest.hexdigest() != file.sha256:
        raise InputError(f"The bundle is refused: {file.path!r} is damaged; its SHA-256 differs from the declared one.")
