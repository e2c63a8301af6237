"""Reads the known results of a world: `analysis/validation/<world>.yaml`, or `mine/validation/<world>.yaml`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import msgspec
import yaml

from foundry.errors import InputError, not_found
from foundry.own_code import own_folders
from foundry.texts import one_line


class ClosedForm(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A measure's value for a scripted policy, computed from a formula.

    Attributes:
        name: name of the value in tables.
        column: the measure, `<signature>.<measure>`.
        why: derivation of the value.
        tolerance: error by rounding of the value, in addition to the Monte Carlo error.
        overrides: settings with which the value holds, such as `world.agents=10`.
    """

    name: str
    policy: str
    column: str
    value: float
    why: str
    tolerance: float = 0.0
    seeds: int = 20
    overrides: tuple[str, ...] = ()


class Published(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A value that a publication gives for a language model.

    Attributes:
        certain: `read` if somebody read the value in the source, `known` if nobody checked it there.
    """

    model: str
    value: float
    source: str
    certain: Literal["read", "known"] = "read"


class Facts(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The known results of a world.

    Attributes:
        score: the measure that represents the world, `<signature>.<measure>`.
        random: the scripted policy that ignores its observations.
        best: the scripted policy with the best score, or None.
        differs: how the world with default settings differs from the one in the source.
    """

    world: str
    score: str
    better: Literal["higher", "lower", "neither"] = "neither"
    random: str = "scripted/random"
    best: str | None = None
    closed_forms: tuple[ClosedForm, ...] = ()
    published: tuple[Published, ...] = ()
    differs: str = ""

    @property
    def policies(self) -> tuple[str, ...]:
        """The policies with which models are compared: `random` and `best`."""
        return tuple(filter(None, (self.random, self.best)))


def policies_of(world: str) -> tuple[str, ...]:
    """Return the policies with which models in a world are compared; none if the world has no known results.

    Raises:
        InputError: the world's file cannot be read.
    """
    facts = facts_of(world)
    return () if facts is None else facts.policies


def facts_of(world: str) -> Facts | None:
    """Return the known results of a world, or None if there are none.

    Raises:
        InputError: the world's file cannot be read.
    """
    file = _files().get(world)
    return None if file is None else _read(file)


def all_facts(worlds: tuple[str, ...] = ()) -> Iterator[Facts]:
    """Yield the known results of the given worlds, by default of all worlds with known results.

    Raises:
        InputError: a world has no known results, or a file cannot be read.
    """
    known = _files()
    for world in worlds or sorted(known):
        if world not in known:
            hint = "Put the known results of your own world into mine/validation/<world>.yaml."
            raise not_found("Known world", world, sorted(known), hint)
        yield _read(known[world])


def _files() -> dict[str, Path]:
    """Return the file of each world; a user's file takes the place of a shipped one."""
    folders = [Path(__file__).parent, *(folder / "validation" for folder in own_folders())]
    return {file.stem: file for folder in folders for file in folder.glob("*.yaml")}


def read_yaml(file: Path) -> Any:
    """Return the content of a YAML file, read by libyaml if it is installed, since it is several times as fast."""
    return yaml.load(file.read_text(encoding="utf-8"), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))


def _read(file: Path) -> Facts:
    try:
        facts = msgspec.convert(read_yaml(file), Facts)
    except (OSError, UnicodeDecodeError, yaml.YAMLError, msgspec.ValidationError) as error:
        raise InputError(f"{file} does not contain valid known results of a world: {one_line(error)}") from error
    if facts.world != file.stem:
        raise InputError(f"{file} is about world '{facts.world}': rename it to {facts.world}.yaml.")
    return facts
