"""The user's own defaults: settings for what a command line leaves open, such as the model, server or runner.

foundry writes the user's defaults into a copy of the primary configuration (`conf/config.yaml`). A named sweep, a
world's file and the command line therefore override the user's defaults. Only for runners and servers, foundry sets
the user's defaults later, after Hydra has composed the configuration.
"""

from collections.abc import Iterator, Mapping, Sequence, Set
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from foundry import paths
from foundry.errors import InputError, not_found
from foundry.expansion import dotted
from foundry.storing.plain import read_config

_PRIMARY = ("cache", "output", "view", "analyze", "determinism")
_RUNNER = "runner"
_SERVER = "model.server"


@dataclass(frozen=True)
class Defaults:
    """The content of the file with a user's own defaults.

    Attributes:
        choices: by group, the option that replaces the shipped default.
        settings: by dotted key, the value that replaces the shipped default.
    """

    choices: Mapping[str, str] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)

    def without_servers(self) -> "Defaults":
        """Return the defaults without settings of servers, since a recorded model keeps its recorded server."""
        settings = {key: value for key, value in self.settings.items() if not key.startswith(f"{_SERVER}.")}
        return Defaults(self.choices, settings)

    def primary(self, content: Mapping[str, Any]) -> dict[str, Any]:
        """Return the content of the primary configuration, with the user's defaults instead of the shipped ones."""
        own = deepcopy(dict(content))
        for entry in own["defaults"]:
            if isinstance(entry, dict):
                entry.update({group: self.choices[group] for group in entry if group in self.choices})
        for key, value in self.settings.items():
            _set(own, key.split("."), value)
        return own

    def put_into(self, config: Mapping[str, Any], given: Set[str]) -> dict[str, Any]:
        """Return a composed configuration with the defaults for its runner and its models' servers.

        Args:
            config: the composed configuration.
            given: keys that the command line sets; the defaults do not change them.
        """
        own = deepcopy(dict(config))
        places = [(_SERVER, *place) for place in _servers("model", own.get("model"))]
        if _RUNNER in own:
            places.append((_RUNNER, _RUNNER, own[_RUNNER]))
        for key, value in self.settings.items():
            for prefix, place, part in places:
                name = key.removeprefix(f"{prefix}.")
                if name != key and f"{place}.{name}" not in given:
                    _set(part, name.split("."), value)
        return own

    def chosen(self, given: Set[str], choices: Sequence[Mapping[str, str]]) -> tuple[str, ...]:
        """Return the user's default choices, as `world=bar`, that no named sweep and no command line replaces."""
        return tuple(
            f"{group}={option}"
            for group, option in self.choices.items()
            if group not in given and any(choice.get(group) == option for choice in choices)
        )

    def hint(self, error: str) -> str:
        """Return a sentence that names the user's file if an error quotes an option from it; else ""."""
        named = any(f"'{group}/{option}'" in error for group, option in self.choices.items())
        return f" Your defaults in {paths.user_config_file()} name this option." if named else ""


def _servers(path: str, part: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the settings of each server of a model or its members, with their dotted key."""
    if isinstance(part, dict):
        for name, inner in part.items():
            if name == "server" and isinstance(inner, dict):
                yield f"{path}.server", inner
            else:
                yield from _servers(f"{path}.{name}", inner)


def _set(part: dict[str, Any], path: Sequence[str], value: Any) -> None:
    *outer, last = path
    for name in outer:
        part = part.get(name, {})
    if last in part:
        part[last] = value


def read_defaults() -> Defaults:
    """Read the user's file of defaults, which may be missing."""
    file = paths.user_config_file()
    if not file.is_file():
        return Defaults()
    set_values, (groups, keys) = dict(dotted(resolved(read_config(file), file))), _known()
    choices = {key: value for key, value in set_values.items() if key in groups and isinstance(value, str)}
    settings = {key: value for key, value in set_values.items() if key not in choices}
    for key in settings:
        if key not in keys:
            more = (
                "Defaults may choose parts, and say where and how to run them. Use the command line for other settings."
            )
            raise not_found(f"{file}: setting", key, groups | keys, more)
    return Defaults(choices, settings)


def _known() -> tuple[set[str], set[str]]:
    conf = paths.conf_dir()
    primary = read_config(conf / "config.yaml")
    groups = {group for entry in primary["defaults"] if isinstance(entry, dict) for group in entry if " " not in group}
    parts = [{key: primary[key] for key in _PRIMARY}]
    parts += [{_RUNNER: read_config(file)} for file in (conf / _RUNNER).glob("*.yaml")]
    models = [read_config(file) for file in (conf / "model").glob("*.yaml")]
    parts += [{_SERVER: model["server"]} for model in models if "server" in model]
    return groups, {key for part in parts for key, _ in dotted(part) if not key.endswith("_target_")}


def resolved(config: Any, file: Path) -> dict[str, Any]:
    """Return the settings of a file, with references such as `${oc.env:HOME}` replaced by their values."""
    from omegaconf import OmegaConf
    from omegaconf.errors import OmegaConfBaseException

    if not isinstance(config, Mapping | None):
        raise InputError(f"{file} contains no settings. Write one per line, such as cache.path: answers.sqlite")
    try:
        resolved: Any = OmegaConf.to_container(OmegaConf.create(dict(config or {})), resolve=True)
    except (OmegaConfBaseException, ValueError) as error:
        raise InputError(f"{file} cannot be used: {str(error).splitlines()[0]}") from error
    return {str(key): value for key, value in resolved.items()}
