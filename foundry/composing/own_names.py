"""The names of a user's own parts: none of them may be the name of a shipped part."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path

from foundry import paths
from foundry.own_code import refuse_shipped_name

_CONFIG, _CODE = "*.yaml", "[!_]*.py"


def check_own_names(folders: Iterable[Path]) -> None:
    """Refuse folders in which a part has the name of a shipped part.

    Raises:
        InputError: one has; names both files.
    """
    groups = _groups()
    for folder in folders:
        for group, (pattern, _) in groups.items():
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
    group, groups = file.relative_to(folder).parts[0], _groups()
    if group not in groups:
        return
    pattern, shipped_parts = groups[group]
    shipped = shipped_parts()
    name, own = _name_of(file, folder / group), (folder / group).rglob(pattern)
    if file not in shipped.values():
        refuse_shipped_name(str(file), name, shipped, {_name_of(path, folder / group) for path in own})


def _name_of(file: Path, room: Path) -> str:
    return file.relative_to(room).with_suffix("").as_posix()


def _files(pattern: str, rooms: Sequence[Path]) -> Mapping[str, Path]:
    return {_name_of(path, room): path for room in rooms for path in room.rglob(pattern)}


def _edits() -> Mapping[str, Path]:
    from foundry.worlds.probe.editing import shipped_edits  # with numpy, which most commands do without

    return shipped_edits()


def _groups() -> dict[str, tuple[str, Callable[[], Mapping[str, Path]]]]:
    """Return the pattern of the files of each group of parts, and what returns the shipped ones by name."""
    rooms = {folder.name: [folder] for folder in paths.conf_dir().iterdir() if folder.is_dir()}
    rooms["sweep"] = [paths.sweeps_dir()]
    signatures = list((paths.PACKAGE.parent / "analysis").glob("*/signatures"))
    return {
        **{group: (_CONFIG, partial(_files, _CONFIG, folders)) for group, folders in rooms.items()},
        "signatures": (_CODE, partial(_files, _CODE, signatures)),
        "edits": (_CODE, _edits),
    }
