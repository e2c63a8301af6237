"""Checks folders and YAML files that someone else may have made.

Only regular files are allowed: a link could make foundry read or overwrite other files, and a named pipe could make it
wait for ever. YAML files may only have plain values, a limited size and a limited depth.
"""

import contextlib
import os
import re
import stat
from pathlib import Path
from typing import Any

import yaml

from foundry.errors import RecordError

LARGEST = 256 * 1024 * 1024
"""Maximum size of a YAML text, characters."""
DEEPEST = 100
"""Maximum number of nested levels; at some tens of thousands of levels the parser crashes the process."""
_PARSER_DEPTH = "exceeded maximum nesting depth"
"""The error text with which newer versions of libyaml refuse YAML with more than a thousand nested levels."""
MOST_VALUES = 20_000_000
"""Maximum number of values in a YAML text, where a value that an alias repeats counts each time."""
MOST_SETTINGS = 100_000
"""Maximum number of values in a configuration file: fewer than in other files, because each value becomes an object."""

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_RUN_LINE = re.compile(r'^- \{"id":"[\w-]+","condition":\d+,"seed":\d+\}$', re.MULTILINE)
"""A line of `sweep.yaml` that defines a run. The check of nested levels skips such lines: there may be very many."""
_LINKS = frozenset({0xA000000C, 0xA0000003})
"""The tags of symbolic links and junctions on Windows. Files with other tags, such as cloud files, count as regular."""
_REFUSED = {
    stat.S_IFLNK: "a link",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def is_there(path: Path) -> bool:
    """Return whether a file or folder exists, without opening it."""
    return _status(path) is not None


def stamp_of(path: Path) -> str:
    """Return a text that changes when a file is replaced or grows; "" if the file does not exist."""
    status = _status(path)
    return "" if status is None else f"{status.st_mtime_ns:x}-{status.st_ino:x}-{status.st_size:x}"


def _status(path: Path) -> os.stat_result | None:
    try:
        status = os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:
        raise RecordError(f"{path} cannot be read: {error}") from error
    _check(path, status)
    return status


def plain(path: Path) -> Path:
    """Return the path, after checking that it is a regular file, a folder, or missing."""
    is_there(path)
    return path


def check_folder(folder: Path, *, shallow: str = "", apart: str = "") -> None:
    """Check that a folder contains only regular files and folders; the folder itself may be a link.

    Args:
        folder: the folder.
        shallow: name of a subfolder whose own subfolders are not checked, since there may be very many.
        apart: name of a subfolder that is not checked.
    """
    waiting = [(os.fspath(folder), True)]
    while waiting:
        place, deep = waiting.pop()
        is_top = place == os.fspath(folder)
        for entry in check_entries(place):
            if deep and not (is_top and entry.name == apart):
                waiting.append((entry.path, not (is_top and entry.name == shallow)))


def check_entries(folder: Path | str) -> list[os.DirEntry[str]]:
    """Check the direct entries of a folder, and return the subfolders among them."""
    folders = []
    for entry in _entries(folder):
        if entry.is_file(follow_symlinks=False):
            continue
        is_folder = entry.is_dir(follow_symlinks=False)
        if not is_folder or os.name == "nt":  # on Windows, a junction looks like a folder
            with contextlib.suppress(FileNotFoundError):  # others may write and remove files meanwhile
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


def _check(path: Path | str, info: os.stat_result) -> None:
    is_link = getattr(info, "st_reparse_tag", 0) in _LINKS
    what = _REFUSED.get(stat.S_IFLNK if is_link else stat.S_IFMT(info.st_mode))
    if what is not None:
        raise RecordError(
            f"'{path}' is refused: it is {what}, but a sweep's folder may only contain regular files and folders. "
            "Replace it with a regular file, or remove it."
        )


def read_config(file: Path) -> Any:
    """Return the content of a configuration file."""
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
    return load_plain(text, file, most=MOST_SETTINGS)


def load_plain(text: str, where: object, *, most: int = MOST_VALUES) -> Any:
    """Return the value of a YAML text; errors name its origin `where`."""
    if len(text) > LARGEST:
        raise RecordError(f"{where} is refused: it has {len(text):,} characters, more than {LARGEST:,}.")
    if _depth(_RUN_LINE.sub("", text), where) > DEEPEST:
        raise RecordError(f"{where} is refused: it has more than {DEEPEST} nested levels.")
    try:
        value = yaml.load(text, Loader=_Loader)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise RecordError(f"{where} cannot be read: {type(error).__name__}: {' '.join(str(error).split())}") from error
    _check_expanded(value, where, most)
    return value


def _depth(text: str, where: object) -> int:
    """Return the number of nested levels of a YAML text; counting stops beyond the limit."""
    depth = deepest = 0
    try:
        for event in yaml.parse(text, Loader=_Loader):
            if isinstance(event, yaml.CollectionStartEvent):
                depth += 1
                deepest = max(deepest, depth)
                if deepest > DEEPEST:
                    break
            elif isinstance(event, yaml.CollectionEndEvent):
                depth -= 1
    except yaml.YAMLError as error:
        if getattr(error, "problem", "") == _PARSER_DEPTH:
            return DEEPEST + 1
        raise RecordError(f"{where} cannot be read: {' '.join(str(error).split())}") from error
    return deepest


def _check_expanded(value: Any, where: object, most: int) -> None:
    """Raise an error if a YAML value has too many parts. A part counts again for each YAML alias that repeats it."""
    counts: dict[int, int] = {}
    open_parts: set[int] = set()

    def count(part: Any) -> int:
        if not isinstance(part, dict | list):
            return 1
        if id(part) in open_parts:
            raise RecordError(f"{where} is refused: a part of it contains itself.")
        if id(part) not in counts:
            open_parts.add(id(part))
            inner = part.values() if isinstance(part, dict) else part
            counts[id(part)] = 1 + sum(map(count, inner))
            open_parts.remove(id(part))
        return counts[id(part)]

    if count(value) > most:
        raise RecordError(f"{where} is refused: with its aliases expanded it has more than {most:,} values.")
