"""Keeps names unique: gives each class one name, and rejects users' parts with the names of shipped parts."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from foundry import paths
from foundry.errors import InputError
from foundry.naming import target_of
from foundry.own_code import refuse_shipped_name

_CONFIG, _CODE = "*.yaml", "[!_]*.py"


def with_public_names(value: Any) -> Any:
    """Return a configuration in which each class has its public name (`_target_`), even in nested parts.

    The public name is the attribute `public_name` of the class, or else the path of its definition. So a class has one
    name, even if users name it by different paths. A target that cannot be found stays as it is.
    """
    if isinstance(value, Mapping):
        return {
            key: _public_name(inner) if key == "_target_" else with_public_names(inner) for key, inner in value.items()
        }
    return [with_public_names(inner) for inner in value] if isinstance(value, list | tuple) else value


def _public_name(target: Any) -> Any:
    try:
        part = target_of(target)
    except Exception:  # noqa: BLE001 - a user's own module may raise anything; building it reports the error
        return target
    name = vars(part).get("public_name") if isinstance(part, type) else None
    if name is None:
        return f"{part.__module__}.{part.__qualname__}" if isinstance(part, type) else target
    try:
        known = target_of(name)
    except (ImportError, AttributeError, ValueError) as error:
        raise InputError(
            f"{target} has the public_name '{name}', which cannot be imported. Write a path that leads to the class."
        ) from error
    if known is not part:
        raise InputError(
            f"{target} has the public_name '{name}', which is another class. Write a path that leads to the class."
        )
    return name


def check_own_names(folders: Iterable[Path]) -> None:
    """Raise an error if one of a user's folders has a part with the name of a shipped part."""
    groups = _groups()
    for folder in folders:
        for group, (pattern, _) in groups.items():
            for file in sorted((folder / group).rglob(pattern)):
                check_own_name(file, folder)


def check_own_name(file: Path, folder: Path) -> None:
    """Raise an error if the part in a file has the name of a shipped part."""
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
    from foundry.worlds.probe.editing import shipped_edits  # imports numpy, which most commands do not need

    return shipped_edits()


def _groups() -> dict[str, tuple[str, Callable[[], Mapping[str, Path]]]]:
    """Return, for each kind of part: the pattern of its files, and a function that lists the shipped parts."""
    rooms = {folder.name: [folder] for folder in paths.conf_dir().iterdir() if folder.is_dir()}
    rooms["sweep"] = [paths.sweeps_dir()]
    signatures = list((paths.PACKAGE.parent / "analysis").glob("*/signatures"))
    return {
        **{group: (_CONFIG, partial(_files, _CONFIG, folders)) for group, folders in rooms.items()},
        "signatures": (_CODE, partial(_files, _CODE, signatures)),
        "edits": (_CODE, _edits),
    }
