"""Folders and YAML of unknown origin: plain files, plain values, and nothing that grows or nests without bound.

A link would have us read, hand on or overwrite what is elsewhere; a named pipe would have us wait for ever.
"""

from __future__ import annotations

import contextlib
import os
import re
import stat
from pathlib import Path
from typing import Any

import yaml

from foundry.errors import RecordError

LARGEST = 256 * 1024 * 1024
"""Bytes of text."""
DEEPEST = 100
"""Levels of nesting; the parser would fail at some tens of thousands, and take the process with it."""
_PARSER_DEPTH = "exceeded maximum nesting depth"
"""The problem that newer versions of libyaml state at a thousand levels."""
MOST_VALUES = 20_000_000
"""Values after all aliases are expanded."""
MOST_SETTINGS = 100_000
"""The same in a configuration file, all of which is built as objects."""

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_RUN_LINE = re.compile(r'^- \{"id":"[\w-]+","condition":\d+,"seed":\d+\}$', re.MULTILINE)
"""A run of a sweep, which opens and closes what it opens; there may be very many of them."""
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
    """Return whether there is a file or a folder; nothing of it is opened."""
    return _status(path) is not None


def stamp_of(path: Path) -> str:
    """Return a text that changes when a file is put in the place of another one; empty where there is none."""
    status = _status(path)
    return "" if status is None else f"{status.st_mtime_ns:x}-{status.st_ino:x}"


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
    """Return the path of what may be read or written, whether it is there or not."""
    is_there(path)
    return path


def check_folder(folder: Path, *, shallow: str = "", apart: str = "") -> None:
    """Check all that is in a folder; the folder itself may be anything that leads to one.

    Args:
        folder: the folder.
        shallow: name of a folder in it of whose folders nothing is looked at, since there may be very many.
        apart: name of a folder in it that is looked at by itself.
    """
    waiting = [(os.fspath(folder), True)]
    while waiting:
        place, deep = waiting.pop()
        is_top = place == os.fspath(folder)
        for entry in check_entries(place):
            if deep and not (is_top and entry.name == apart):
                waiting.append((entry.path, not (is_top and entry.name == shallow)))


def check_entries(folder: Path | str) -> list[os.DirEntry[str]]:
    """Check what is in a folder, but not what is in folders of it; returns these folders."""
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


def read_config(file: Path) -> Any:
    """Return the content of a configuration file."""
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
    return load_plain(text, file, most=MOST_SETTINGS)


def load_plain(text: str, where: object, *, most: int = MOST_VALUES) -> Any:
    """Return the value of a YAML text."""
    if len(text) > LARGEST:
        raise RecordError(f"{where} is refused: it has {len(text):,} characters, more than {LARGEST:,}.")
    if _depth(_RUN_LINE.sub("", text), where) > DEEPEST:
        raise RecordError(f"{where} is refused: it nests deeper than {DEEPEST} levels.")
    try:
        value = yaml.load(text, Loader=_Loader)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise RecordError(f"{where} cannot be read: {type(error).__name__}: {' '.join(str(error).split())}") from error
    _check_expanded(value, where, most)
    return value


def _depth(text: str, where: object) -> int:
    """Return how deep the text nests, and stop counting beyond what is allowed."""
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
    """Count the values with every alias expanded, each shared part once."""
    counts: dict[int, int] = {}
    open_parts: set[int] = set()

    def count(part: Any) -> int:
        if not isinstance(part, dict | list):
            return 1
        if id(part) in open_parts:
            raise RecordError(f"{where} is refused: a part of it holds itself.")
        if id(part) not in counts:
            open_parts.add(id(part))
            inner = part.values() if isinstance(part, dict) else part
            counts[id(part)] = 1 + sum(map(count, inner))
            open_parts.remove(id(part))
        return counts[id(part)]

    if count(value) > most:
        raise RecordError(f"{where} is refused: with its aliases expanded it has more than {most:,} values.")
