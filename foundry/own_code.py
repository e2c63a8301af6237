"""Finds your own code: in folders given by `--config-dir`, or through entry points of installed packages.

A file `mine/signatures/greed.py` is a signature module, and so is an entry point in the group `foundry.signatures`.
Python can import every file in `mine/`, but searches this folder last, so that its files hide no module of foundry or
of a library.
"""

import hashlib
import importlib.util
import itertools
import os
import pkgutil
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

from foundry.errors import InputError

VARIABLE = "FOUNDRY_MINE"
"""The environment variable that tells subprocesses of a command which folders contain the user's own code."""
CONFIG_DIR = ("-cd", "--config-dir")
"""The flags with which a user names a folder with code or settings of the user."""
_ROOT = Path(__file__).resolve().parent.parent


def use(folders: Iterable[Path]) -> None:
    """Add your own folders to those that this process and its subprocesses search."""
    use_only([*own_folders(), *(folder.absolute() for folder in folders)])


def use_only(folders: Iterable[Path]) -> None:
    """Search exactly these absolute folders; a reused worker may still know the folders of an earlier task."""
    known = tuple(dict.fromkeys(folders))
    os.environ[VARIABLE] = os.pathsep.join(map(str, known))
    importable(known)


def config_dirs(argv: Sequence[str]) -> Iterator[Path]:
    """Yield the folders that `--config-dir` names on a command line."""
    for flag, value in zip(argv, [*argv[1:], ""], strict=False):
        if flag in CONFIG_DIR:
            yield Path(value)
        elif flag.startswith("--config-dir="):
            yield Path(flag.partition("=")[2])


def folders_last(argv: Sequence[str]) -> list[str]:
    """Move the flags with your own folders to the end of a command line, as `--config-dir FOLDER` for each.

    Hydra does not accept overrides on both sides of a flag.
    """
    rest, folders = list(argv), list(config_dirs(argv))
    while flag := next((word for word in rest if word.partition("=")[0] in CONFIG_DIR), None):
        place = rest.index(flag)
        del rest[place : place + (1 if "=" in flag else 2)]
    return [*rest, *(part for folder in folders for part in (CONFIG_DIR[1], str(folder)))]


def importable(folders: Iterable[Path]) -> None:
    """Append folders to `sys.path`, so that Python looks there for a module only after all other folders."""
    sys.path.extend(str(folder) for folder in folders if str(folder) not in sys.path)


def working_directory_last() -> None:
    """Move the working directory to the end of `sys.path`, so that its files hide no installed module.

    The working directory stays first if it contains this project, or if it is in PYTHONPATH.
    """
    here = Path.cwd()
    if here == _ROOT:
        return
    if not sys.flags.safe_path and sys.path[:1] in ([""], [str(here)]):
        del sys.path[0]
    importable([here])


def ours(name: str) -> ModuleType:
    """Import a module of this project, and raise InputError if another package hides it."""
    package = name.partition(".")[0]
    imported = importlib.import_module(package)
    if imported.__file__ is None or Path(imported.__file__).resolve().parent.parent != _ROOT:
        where = imported.__file__ or ", ".join(imported.__path__)
        raise InputError(
            f"another package named '{package}' hides foundry's own: {where}. Rename it, or start foundry in another "
            "folder."
        )
    return importlib.import_module(name)


def own_folders() -> tuple[Path, ...]:
    """Return the folders with the user's own code."""
    return tuple(Path(folder) for folder in os.environ.get(VARIABLE, "").split(os.pathsep) if folder)


@dataclass(frozen=True)
class OwnModule:
    """A module with the user's own code.

    Attributes:
        origin: its file or its package, for messages.
        target: its file, or the import path of an installed module.
    """

    name: str
    origin: str
    target: Path | str

    def load(self) -> ModuleType:
        """Import the module."""
        try:
            return importlib.import_module(self.target) if isinstance(self.target, str) else _imported(self.target)
        except Exception as error:  # the boundary: any error of a user's file is reported with its name
            cause = " ".join(f"{type(error).__name__}: {error}".split())
            raise InputError(f"{self.origin} cannot be imported: {cause}") from error

    @property
    def sha256(self) -> str:
        """SHA-256 of the module's source file, or `unknown` if the module has none."""
        spec = None if isinstance(self.target, Path) else importlib.util.find_spec(self.target)
        file = self.target if isinstance(self.target, Path) else Path((spec and spec.origin) or os.devnull)
        return hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else "unknown"


def own_modules(group: str) -> Iterator[OwnModule]:
    """Yield your own modules of a group, such as `signatures`: first files, then entry points."""
    for folder in own_folders():
        for file in sorted((folder / group).glob("*.py")):
            if not file.name.startswith("_"):
                yield OwnModule(file.stem, f"{folder.name}/{group}/{file.name}", file)
    yield from _installed(group, tuple(sys.path))


def own_class(target: str) -> type | None:
    """Return the class that a `_target_` names, if a module in your own folders defines it; else None.

    Nothing outside these folders is imported.
    """
    if not _is_in_own_folder(target):
        return None
    try:
        value = pkgutil.resolve_name(target)
    except Exception as error:  # the boundary: any error of a user's file is reported with its name
        raise InputError(f"'{target}' cannot be imported: {type(error).__name__}: {error}") from error
    return value if isinstance(value, type) and _is_in_own_folder(value.__module__) else None


def _spec(name: str) -> ModuleSpec | None:
    try:
        return importlib.util.find_spec(name)
    except (ImportError, ValueError):
        return None


def _is_in_own_folder(name: str) -> bool:
    spec = _spec(name.partition(".")[0])
    places = [] if spec is None else (spec.submodule_search_locations or [spec.origin or os.devnull])
    folders = [folder for folder in own_folders() if folder != _ROOT]
    return bool(places) and all(Path(place).parent in folders for place in places)


def refuse_shipped_name(part: str, name: str, shipped: Mapping[str, object], taken: Collection[str] = ()) -> None:
    """Raise InputError if a user's part has the name of a shipped part.

    Args:
        part: where the user's part comes from, for the message.
        name: its name.
        shipped: file of each shipped part of this kind, by name.
        taken: names of the user's other parts, which the message does not propose.
    """
    if name not in shipped:
        return
    numbered = (f"{name}_{number}" for number in itertools.count(2))
    free = next(other for other in numbered if other not in shipped and other not in taken)
    raise InputError(
        f"{part} has the name '{name}' of a shipped part, {shipped[name]}. Rename your part, for example to '{free}'."
    )


@cache
def _installed(group: str, _path: tuple[str, ...]) -> tuple[OwnModule, ...]:
    """Return the entry points of a group; cached, because the search in all packages takes milliseconds."""
    from importlib.metadata import entry_points  # this import takes as long as the rest of a `--help` command

    return tuple(
        OwnModule(
            point.name, f"{point.value} of {point.dist.name if point.dist else 'an installed package'}", point.value
        )
        for point in entry_points(group=f"foundry.{group}")
    )


@cache
def _imported(file: Path) -> ModuleType:
    natural = f"{file.parent.name}.{file.stem}"
    module_spec = _spec(natural)
    if module_spec is not None and module_spec.origin is not None and Path(module_spec.origin) == file:
        return importlib.import_module(natural)  # any kind of import gives this module, so each class exists once
    name = f"foundry_own_{file.parent.name}_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None and spec.loader is not None, "a .py file has a loader"
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
