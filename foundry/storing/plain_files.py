"""What may be in a sweep's folder, which may come from anyone: files and folders of its own.

A link would have us read, hand on or overwrite what is elsewhere; a named pipe would have us wait for ever.
"""

from __future__ import annotations

import contextlib
import os
import stat
from pathlib import Path

from foundry.errors import RecordError

_LINKS = frozenset({0xA000000C, 0xA0000003})
"""Windows' symbolic links and junctions; other reparse points, such as files kept in a cloud, are what they seem."""
_REFUSED = {
    stat.S_IFLNK: "a link",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def is_there(path: Path) -> bool:
    """Return whether there is a file or a folder; nothing of it is opened.

    Raises:
        RecordError: there is something else.
    """
    return _status(path) is not None


def stamp_of(path: Path) -> str:
    """Return a text that changes when a file is put in the place of another one; empty where there is none.

    Raises:
        RecordError: there is something else than a file or a folder.
    """
    found = _status(path)
    return "" if found is None else f"{found.st_mtime_ns:x}-{found.st_ino:x}"


def _status(path: Path) -> os.stat_result | None:
    try:
        found = os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:
        raise RecordError(f"{path} cannot be read: {error}") from error
    _check(path, found)
    return found


def plain(path: Path) -> Path:
    """Return the path of what may be read or written, whether it is there or not.

    Raises:
        RecordError: something else than a file or a folder is there.
    """
    is_there(path)
    return path


def check_folder(folder: Path, *, shallow: str = "", apart: str = "") -> None:
    """Check all that is in a folder; the folder itself may be anything that leads to one.

    Args:
        folder: the folder.
        shallow: name of a folder in it of whose folders nothing is looked at, since there may be very many.
        apart: name of a folder in it that is looked at by itself.

    Raises:
        RecordError: there is something else than files and folders, or it cannot be looked at.
    """
    waiting = [(os.fspath(folder), True)]
    while waiting:
        place, deep = waiting.pop()
        is_top = place == os.fspath(folder)
        for entry in check_entries(place):
            if deep and not (is_top and entry.name == apart):
                waiting.append((entry.path, not (is_top and entry.name == shallow)))


def check_entries(folder: Path | str) -> list[os.DirEntry[str]]:
    """Check what is in a folder, but not what is in folders of it; returns these folders.

    Raises:
        RecordError: there is something else than files and folders, or it cannot be looked at.
    """
    folders = []
    for entry in _entries(folder):
        if entry.is_file(follow_symlinks=False):
            continue
        is_folder = entry.is_dir(follow_symlinks=False)
        if not is_folder or os.name == "nt":  # there, a junction looks like a folder
            with contextlib.suppress(FileNotFoundError):  # what others write and remove meanwhile
                _check(entry.path, entry.stat(follow_symlinks=False))
        if is_folder:
            folders.append(entry)
    return folders


def _entries(folder: Path | str) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(folder) as entries:
            return list(entries)
    except FileNotFoundError:
        return []
    except OSError as error:
        raise RecordError(f"{folder} cannot be read: {error.strerror}") from error


def _check(path: Path | str, found: os.stat_result) -> None:
    is_link = getattr(found, "st_reparse_tag", 0) in _LINKS
    what = _REFUSED.get(stat.S_IFLNK if is_link else stat.S_IFMT(found.st_mode))
    if what is not None:
        raise RecordError(
            f"'{path}' is refused: it is {what}, and a sweep's folder holds files and folders of its own only. "
            "Put there what it stands for, or remove it."
        )
