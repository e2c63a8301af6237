"""Reads what is known of a world: `analysis/validation/<world>.yaml`, or `mine/validation/<world>.yaml`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import msgspec
import yaml

from foundry.errors import InputError, not_found
from foundry.own_code import own_folders


class ClosedForm(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A number that a scripted policy must come to.

    Attributes:
        name: a word for people.
        policy: the model that plays.
        column: the measure, `<signature>.<measure>`.
        value: what it must come to in the mean over seeds.
        why: where the number comes from.
        tolerance: rounding of the number itself; the Monte Carlo error comes on top.
        seeds: how many seeds are played.
        overrides: further settings.
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
    """A figure of a language model in a source.

    Attributes:
        model: its name as a tag.
        value: of the world's score.
        source: where it stands.
        certain: `read` in the source, or `known` but not checked in it.
    """

    model: str
    value: float
    source: str
    certain: Literal["read", "known"] = "read"


class Facts(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is known of a world.

    Attributes:
        world: its name.
        score: the measure that stands for it, `<signature>.<measure>`.
        better: which end of the score is the better one.
        random: the policy that looks at nothing.
        best: the scripted policy that is best at it, or None.
        closed_forms: what scripted policies must come to.
        published: figures of language models.
        differs: in a word what is not as in the source where the world is played at its defaults.
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
        """The policies that the score is held against: the one that looks at nothing and the best one."""
        return tuple(filter(None, (self.random, self.best)))


def policies_of(world: str) -> tuple[str, ...]:
    """Return the policies that a world's score is held against; empty where nothing is known of the world.

    Raises:
        InputError: the world's file cannot be read.
    """
    facts = facts_of(world)
    return () if facts is None else facts.policies


def facts_of(world: str) -> Facts | None:
    """Return what is known of a world; None where nothing is.

    Raises:
        InputError: its file cannot be read.
    """
    file = _files().get(world)
    return None if file is None else _read(file)


def all_facts(worlds: tuple[str, ...] = ()) -> Iterator[Facts]:
    """Yield what is known of these worlds, by default of all of which anything is.

    Raises:
        InputError: nothing is known of a world, or a file cannot be read.
    """
    known = _files()
    for world in worlds or sorted(known):
        if world not in known:
            hint = "What is known of a world of your own stands in mine/validation/<world>.yaml."
            raise not_found("Known world", world, sorted(known), hint)
        yield _read(known[world])


def _files() -> dict[str, Path]:
    """Return the file of each world, the user's own before ours."""
    folders = [Path(__file__).parent, *(folder / "validation" for folder in own_folders())]
    return {file.stem: file for folder in folders for file in folder.glob("*.yaml")}


def read_yaml(file: Path) -> Any:
    """Return what a file says; libyaml's parser, where it is installed, is several times as fast."""
    return yaml.load(file.read_text(encoding="utf-8"), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))


def _read(file: Path) -> Facts:
    try:
        facts = msgspec.convert(read_yaml(file), Facts)
    except (OSError, UnicodeDecodeError, yaml.YAMLError, msgspec.ValidationError) as error:
        raise InputError(f"{file} does not say what is known of a world: {' '.join(str(error).split())}") from error
    if facts.world != file.stem:
        raise InputError(f"{file} is about world '{facts.world}': name the file {facts.world}.yaml.")
    return facts
