"""The names of a user's own parts: none of them may be the name of a shipped part."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from foundry import paths
from foundry.own_code import refuse_shipped_name

_CONFIG, _CODE = "*.yaml", "[!_]*.py"


def check_own_names(folders: Iterable[Path]) -> None:
    """Refuse folders in which a part has the name of a shipped part.

    Raises:
        InputError: one has; names both files.
    """
    shipped = _shipped_rooms()
    for folder in folders:
        for group, (pattern, _) in shipped.items():
            for file in sorted((folder / group).rglob(pattern)):
                check_own_name(file, folder)


def check_own_name(file: Path, folder: Path) -> None:
    """Refuse a part that has the name of a shipped part.

    Args:
        file: the part's file, which need not be there yet.
        folder: the folder of the user's own parts.

    Raises:
        InputError: the name is taken; names both files.
    """
    group, known = file.relative_to(folder).parts[0], _shipped_rooms()
    if group not in known:
        return
    pattern, rooms = known[group]
    shipped = {_name_of(path, room): path for room in rooms for path in room.rglob(pattern)}
    name, own = _name_of(file, folder / group), (folder / group).rglob(pattern)
    if file not in shipped.values():
        refuse_shipped_name(str(file), name, shipped, {_name_of(path, folder / group) for path in own})


def _name_of(file: Path, room: Path) -> str:
    return file.relative_to(room).with_suffix("").as_posix()


def _shipped_rooms() -> dict[str, tuple[str, list[Path]]]:
    """Return the pattern and the shipped folders of the files of each group of parts."""
    configured = (folder for folder in paths.conf_dir().iterdir() if folder.is_dir())
    edits = paths.PACKAGE / "worlds" / "probe" / "edits"
    return {
        **{folder.name: (_CONFIG, [folder]) for folder in configured},
        "sweep": (_CONFIG, [paths.sweeps_dir()]),
        "signatures": (_CODE, list((paths.PACKAGE.parent / "analysis").glob("*/signatures"))),
        "edits": (_CODE, [room for room in edits.iterdir() if room.is_dir()]),
    }
