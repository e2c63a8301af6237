"""Writes the first files of your own part from the templates in `foundry/new_parts/`; these files run unchanged."""

import importlib.util
import keyword
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from foundry import paths
from foundry.composing.names import check_own_name
from foundry.errors import InputError, StorageError, not_found

_NAME, _CLASS = "part_name", "PartName"
"""Texts in the template files that foundry replaces by the name of the new part and the name of its class."""
_TRY_IT = "try_it.txt"
_PLAIN = re.compile(r"[a-z][a-z0-9_]{0,59}")


@dataclass(frozen=True)
class Begun:
    """The files that were written, and a command that runs them."""

    files: tuple[Path, ...]
    try_it: str


def begin(kind: str, name: str, into: Path) -> Begun:
    """Write the files of a new part: a world, signature, prompt, model, policy, edit or form."""
    patterns = paths.shipped_parts()
    kinds = [folder.name for folder in patterns.iterdir() if (folder / _TRY_IT).is_file()]
    if kind not in kinds:
        raise not_found("Kind of part", kind, kinds)
    new = dict(_written(patterns / kind, name, into))
    _check_name(name, [file for file in new if file.parent == into])
    for file in new:
        check_own_name(file, into)
        if file.exists() or file.is_symlink():
            raise InputError(
                f"'{file}' exists, and foundry does not change it. Choose another name, or --into=<folder>."
            )
    try:
        for file, text in new.items():
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
    except OSError as error:
        raise StorageError(f"'{into}' cannot be written: {error}") from error
    try_it = (patterns / kind / _TRY_IT).read_text(encoding="utf-8").strip()
    return Begun(tuple(new), try_it.format(into=into, name=name))


def _written(pattern: Path, name: str, into: Path) -> Iterator[tuple[Path, str]]:
    for source in sorted(pattern.rglob("*.*")):
        if source.suffix in (".py", ".yaml", ".js"):
            text = source.read_text(encoding="utf-8")
            place = source.relative_to(pattern)
            yield into / place.parent / place.name.replace(_NAME, name), _named(text, name, into)


def _named(text: str, name: str, into: Path) -> str:
    in_words = "".join(part.capitalize() for part in name.split("_"))
    return text.replace(_NAME, name).replace(_CLASS, in_words).replace("--config-dir mine", f"--config-dir {into}")


def _check_name(name: str, modules: list[Path]) -> None:
    """Reject a name that no module can have, or that another module has, which Python would import instead."""
    if not _PLAIN.fullmatch(name) or keyword.iskeyword(name):
        raise InputError(f"A name must have small letters, digits and _, such as el_farol; got '{name}'.")
    for module in modules:
        spec = importlib.util.find_spec(module.stem)
        if spec is not None and module.suffix == ".py":
            raise InputError(
                f"'{name}' would not be found, since another module has that name: {spec.origin}. Choose another name."
            )
