"""A user's own defaults: settings that take the place of those in configuration files, below all that is asked for.

They are put into copies of the files that have such a setting. So a named sweep, a world that chooses and the
command line stand above them, and `model.server.hosts` is set of the models that have servers. What was recorded, as
the run that a fork goes on from, stays as it is.
"""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator, Mapping, Sequence, Set
from copy import deepcopy
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import msgspec

from foundry import own_code, paths
from foundry.errors import InputError, not_found
from foundry.expansion import dotted, models_in
from foundry.storing.plain import read_config

_PRIMARY = "config.yaml"
_DECIDING = ("world", "model", "prompt", "format", "schema", "seed", "sampling_seed", "record", "baselines")
_NEVER = ("_target_", "name", "public_name", "defaults", "hydra")
"""What a file says of itself, and no default can say for all files of a group."""


@dataclass(frozen=True)
class Defaults:
    """The content of a user's file.

    Attributes:
        choices: by group the option that takes the place of the shipped one.
        own: the settings, nested as in a configuration.
        applied: by dotted key what has taken the place of another value so far.
        known: the dotted keys of the files that were looked at so far.
    """

    choices: Mapping[str, str] = field(default_factory=dict)
    own: Mapping[str, Any] = field(default_factory=dict)
    applied: dict[str, Any] = field(default_factory=dict)
    known: set[str] = field(default_factory=set)

    @contextlib.contextmanager
    def put_into(self, folders: Sequence[Path]) -> Iterator[Path]:
        """Yield a folder with the primary configuration, and with each file that the defaults change."""
        with tempfile.TemporaryDirectory() as name:
            for folder, file in self._files(folders):
                text = file.read_text(encoding="utf-8")
                changed = self._changed(text, file.relative_to(folder).parts[0])
                if changed is not None or file.name == _PRIMARY:
                    copy = Path(name) / file.relative_to(folder)
                    copy.parent.mkdir(parents=True, exist_ok=True)
                    copy.write_text(text if changed is None else _as_file(changed, text), encoding="utf-8")
            yield Path(name)

    def check(self, folders: Sequence[Path]) -> None:
        """Refuse a setting that no file has."""
        for folder, file in self._files(folders):
            self._changed(file.read_text(encoding="utf-8"), file.relative_to(folder).parts[0])
        for key in (*self.choices, *(key for key, _ in dotted(self.own))):
            if not any(f"{key}.".startswith(f"{applied}.") for applied in self.applied):
                parent = key.rpartition(".")[0]
                beside = {
                    name
                    for name in self.known
                    if name.startswith(f"{key}.") or (parent and name.rpartition(".")[0] == parent)
                }
                top = {name for name in self.known if "." not in name} | shipped_groups()
                raise not_found(f"{paths.user_config_file()}: setting", key, beside or top)

    def _files(self, folders: Sequence[Path]) -> Iterator[tuple[Path, Path]]:
        """Yield the primary configuration and each file that the defaults may change, after its folder."""
        yield folders[0], folders[0] / _PRIMARY
        groups = sorted({*self.own, *shipped_groups()}) if self.own else []
        for folder in folders:
            for group in groups:
                for file in sorted((folder / group).rglob("*.yaml")):
                    yield folder, file

    def _changed(self, text: str, group: str) -> dict[str, Any] | None:
        """Return the content of a group's file with the defaults; None where they change nothing."""
        if self.is_empty:
            return None
        is_global = "@package _global_" in text
        if group != _PRIMARY and not is_global and group not in self.own:
            return None
        content = deepcopy(_content(text))
        if not isinstance(content, dict):
            return None
        keys = dotted(content) if group == _PRIMARY or is_global else dotted({group: content})
        self.known.update(key for key, _ in keys if not set(key.split(".")) & set(_NEVER))
        if group == _PRIMARY:
            is_changed = any([self._choose(entry) for entry in content["defaults"] if isinstance(entry, dict)])
            is_changed |= self._put(content, self.own, "")
        elif is_global:
            is_changed = self._put(content, self.own, "")
        else:
            is_changed = self._put(content, self.own[group], f"{group}.")
        return content if is_changed else None

    @property
    def is_empty(self) -> bool:
        """Whether there are none."""
        return not self.choices and not self.own

    def in_effect(
        self, said: Set[str], conditions: Sequence[Mapping[str, Any]], chosen: Sequence[Mapping[str, str]]
    ) -> dict[str, Any]:
        """Return by dotted key what holds in some condition, since nothing above it says otherwise."""
        left = {key: value for key, value in self.applied.items() if key not in said}
        options = {key for key in left if key in self.choices and any(one.get(key) == left[key] for one in chosen)}
        values = {key for key in left if any(left[key] == found for one in conditions for found in _values(one, key))}
        return {key: value for key, value in left.items() if key in options | values}

    def hint(self, error: str) -> str:
        """Return what to add to an error that is about an option of the user's file."""
        named = any(f"'{group}/{option}'" in error for group, option in self.choices.items())
        return f" It is named in {paths.user_config_file()}." if named else ""

    def _choose(self, entry: dict[str, Any]) -> bool:
        """Have an entry of the list of files name the user's option."""
        (group,) = entry
        if group not in self.choices:
            return False
        entry[group] = self.applied[group] = self.choices[group]
        return True

    def _put(self, config: dict[str, Any], own: Mapping[str, Any], prefix: str) -> bool:
        is_changed = False
        for name, value in own.items():
            there = config.get(name)
            if name not in config or name in _NEVER:
                continue
            if isinstance(there, dict) and there:
                is_changed |= isinstance(value, Mapping) and self._put(there, value, f"{prefix}{name}.")
            else:
                config[name] = self.applied[f"{prefix}{name}"] = value
                is_changed = True
        return is_changed


@lru_cache(maxsize=512)
def _content(text: str) -> Any:
    """Return the content of a file, which nobody may change: OmegaConf takes long to read one."""
    from omegaconf import OmegaConf

    return OmegaConf.to_container(OmegaConf.create(text))


def _as_file(content: Mapping[str, Any], text: str) -> str:
    """Return changed content as the text of a file, below what the unchanged text says to Hydra."""
    from omegaconf import OmegaConf

    header = "".join(line for line in text.splitlines(keepends=True) if line.startswith("# @"))
    return header + OmegaConf.to_yaml(OmegaConf.create(dict(content)))


def deciding(used: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the defaults that decide what a run is, and not only where and how it is run, as overrides."""
    return tuple(
        f"{key}={value if isinstance(value, str) else msgspec.json.encode(value).decode()}"
        for key, value in used.items()
        if key.partition(".")[0] in _DECIDING and "server" not in key.split(".")
    )


def read_defaults(argv: Sequence[str] = ()) -> Defaults:
    """Read the user's file; there need be none."""
    file = paths.user_config_file()
    if not file.is_file():
        return Defaults()
    settings = resolved(read_config(file), file)
    groups = shipped_groups()
    choices = {name: value for name, value in settings.items() if name in groups and isinstance(value, str)}
    defaults = Defaults(choices, _nested({name: value for name, value in settings.items() if name not in choices}))
    defaults.check([paths.conf_dir(), *own_code.folders_named(argv)])
    return defaults


def shipped_groups() -> set[str]:
    """Return the names of the shipped groups of configurations."""
    return {folder.name for folder in paths.conf_dir().iterdir() if folder.is_dir()}


def resolved(found: Any, file: Path) -> dict[str, Any]:
    """Return settings as a file holds them, with the values that it takes from the environment."""
    from omegaconf import OmegaConf
    from omegaconf.errors import OmegaConfBaseException

    if not isinstance(found, Mapping | None):
        raise InputError(f"{file} holds no settings: write one a line, such as cache.path: answers.sqlite")
    try:
        resolved: Any = OmegaConf.to_container(OmegaConf.create(dict(found or {})), resolve=True)
    except (OmegaConfBaseException, ValueError) as error:
        raise InputError(f"{file} cannot be used: {str(error).splitlines()[0]}") from error
    return {str(key): value for key, value in resolved.items()}


def _nested(found: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings with dotted keys as nested ones."""
    nested: dict[str, Any] = {}
    for key, value in found.items():
        place, (*outer, last) = nested, str(key).split(".")
        for part in outer:
            place = place.setdefault(part, {})
        if isinstance(value, Mapping):
            place.setdefault(last, {}).update(_nested(value))
        else:
            place[last] = value
    return nested


def _values(config: Mapping[str, Any], key: str) -> Iterator[Any]:
    """Yield the values of a setting; of a model's also those of the models that it is made of."""
    first, *rest = key.split(".")
    part = config.get(first)
    for one in models_in(part) if first == "model" and isinstance(part, Mapping) else [part]:
        value: Any = one
        for name in rest:
            value = value.get(name) if isinstance(value, Mapping) else None
        yield value
