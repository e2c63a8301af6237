"""From a command line to composed conditions, by Hydra; its errors become one clear line."""

from __future__ import annotations

import contextlib
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from foundry import own_code, paths
from foundry.composing.collecting import Collector, Launch
from foundry.composing.defaults import Defaults, deciding
from foundry.composing.own_names import check_own_names
from foundry.composing.public_names import with_public_names
from foundry.composing.settings import check_parts, check_settings_of_hydra, checked_settings
from foundry.errors import FoundryError, InputError, not_found
from foundry.expansion import FORMAT, Condition, Sweep, expand, has_range, named_formats, overridden
from foundry.naming import format_of
from foundry.storing.plain_yaml import check_config

CONDITION_KEYS = ("world", "model", "prompt", "sampling_seed", "record", "baselines")
"""What goes into a condition; the other keys say where and how it is run."""
_TAKEN_UP = ("seed", "schema")
"""What other parts of a configuration refer to or are multiplied by, and is nothing by itself."""

_SWEPT_ONLY = ("world", "model", "prompt", "format", "layout", "scene", "task", "sampling_seed")
_MULTIRUN = ("-m", "--multirun")
_SHOWING = ("--cfg", "--info")


@dataclass(frozen=True)
class Composed:
    """A composed command line.

    Attributes:
        asked: the overrides as given.
        conditions: the points of the sweep, each with its seeds.
        settings: the keys that say where and how to run: cache, record, output, runner, analyze.
        first: what Hydra composed for the first condition.
        launch: has one of Hydra's own launchers call a function in a job for each list of overrides; None where
            none was asked for.
        defaults: by dotted key what of it comes from the user's own defaults; what decides a run is asked for, too.
        choices: by group its option in the first condition.
        left_out: one line on worlds of a named sweep that need a missing package and are left out; else empty.
    """

    asked: tuple[str, ...]
    conditions: tuple[Condition, ...]
    settings: Mapping[str, Any]
    first: Any
    launch: Launch | None = None
    defaults: Mapping[str, Any] = field(default_factory=dict)
    choices: Mapping[str, str] = field(default_factory=dict)
    left_out: str = ""

    @property
    def sweep(self) -> Sweep:
        """Its runs."""
        return expand(self.asked, self.conditions)

    @property
    def multirun(self) -> str:
        """Hydra's configuration of the sweep as YAML."""
        from omegaconf import OmegaConf

        return OmegaConf.to_yaml(self.first, resolve=False)

    @property
    def deciding(self) -> tuple[str, ...]:
        """Those of the defaults that decide what a run is, as overrides; they stand in what was asked."""
        return deciding(self.defaults)


def compose(argv: Sequence[str], defaults: Defaults | None = None) -> Composed | None:
    """Compose a command line as `foundry` takes it.

    Args:
        argv: the command line.
        defaults: the user's own; by default there are none.

    Returns:
        The conditions, or None when Hydra answered a flag of its own (`--cfg`, `--info`, `--hydra-help`).

    Raises:
        InputError: the command line asks for something that does not exist or cannot be read.
    """
    argv = [named_formats(arg) for arg in own_code.folders_last(argv)]
    _check_flags(argv)
    check_settings_of_hydra(argv)
    own_code.use(own_code.config_dirs(argv))
    check_own_names(own_code.own_folders())
    from hydra.errors import HydraException
    from omegaconf.errors import OmegaConfBaseException

    defaults = defaults or Defaults()
    try:
        _check_groups(argv)
        with _texts_parsed_once():
            collector = _run_hydra(argv, defaults)
            return _composed(argv, collector, defaults) if collector.conditions else None
    except FoundryError:
        raise
    except (HydraException, OmegaConfBaseException) as error:
        raise InputError(f"{_explained(error, argv)}{defaults.hint(str(error))}") from error


def _check_flags(argv: Sequence[str]) -> None:
    """Refuse what Hydra would take for one run, or end in a traceback or its own usage."""
    from hydra._internal.utils import get_args_parser

    unknown = [arg for arg in get_args_parser().parse_known_args(argv)[1] if arg.startswith("-")]
    if unknown:
        raise InputError(f"'{unknown[0]}' is no option here: the command with --help lists those that it has.")
    if any(arg in _MULTIRUN for arg in argv) and any(arg.startswith(_SHOWING) for arg in argv):
        raise InputError("--cfg and --info show one run: leave out -m.")
    is_sweep = any(arg in _MULTIRUN or arg.startswith("+sweep=") for arg in argv)
    ranges = [arg for arg in argv if has_range(arg)]
    if ranges and not is_sweep:
        raise InputError(f"'{ranges[0]}' asks for several runs: add -m, as in foundry -m {' '.join(argv)}")


def _check_groups(argv: Sequence[str]) -> None:
    """Refuse a choice in a group of configurations that is no name; Hydra would end in a traceback."""
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.core.override_parser.types import Override, QuotedString, Transformer

    def names(override: Override) -> list[Any]:
        value = override.value()
        swept = override.sweep_iterator(Transformer.identity) if override.is_sweep_override() else [value]
        return [name for chosen in swept for name in (chosen if isinstance(chosen, list) else [chosen])]

    groups = _groups()
    chosen = [arg for arg in argv if "=" in arg and arg.lstrip("+").partition("=")[0] in groups]
    for override in OverridesParser.create().parse_overrides(chosen):
        if not all(isinstance(name, str | QuotedString) for name in names(override)):
            group = str(override.key_or_group)
            options = (file.stem for file in (paths.conf_dir() / group).glob("*.yaml"))
            raise not_found(group.capitalize(), override.get_value_string(), options)


def _groups() -> set[str]:
    """Return the names of the groups of configurations."""
    return {folder.name for folder in paths.conf_dir().iterdir() if folder.is_dir()}


def _run_hydra(argv: Sequence[str], defaults: Defaults) -> Collector:
    """Let Hydra read the command line; nothing is run by it."""
    import hydra

    collector = Collector()
    with _hydra_surroundings(argv), _composed_once(argv), _files_read(defaults):
        hydra.main(version_base="1.3", config_path=str(paths.conf_dir()), config_name="config")(collector)()
    return collector


@contextlib.contextmanager
def _hydra_surroundings(argv: Sequence[str]) -> Iterator[None]:
    """Hand Hydra the command line, and have it raise its errors instead of printing them."""
    kept_argv, kept_flag = sys.argv, os.environ.get("HYDRA_FULL_ERROR")
    sys.argv = ["foundry", *argv]
    os.environ["HYDRA_FULL_ERROR"] = "1"
    try:
        yield
    finally:
        sys.argv = kept_argv
        if kept_flag is None:
            del os.environ["HYDRA_FULL_ERROR"]
        else:
            os.environ["HYDRA_FULL_ERROR"] = kept_flag


@contextlib.contextmanager
def _instead(owner: Any, name: str, other: Any) -> Iterator[None]:
    """Put something in the place of what Hydra or OmegaConf has under a name."""
    kept = getattr(owner, name)
    setattr(owner, name, other)
    try:
        yield
    finally:
        setattr(owner, name, kept)


@contextlib.contextmanager
def _texts_parsed_once() -> Iterator[None]:
    """Have OmegaConf parse each text that refers to a setting once a process: it only reads what its parser gives."""
    from omegaconf import _utils, base

    with _instead(base, "parse", _parsed), _instead(_utils, "parse", _parsed):
        yield


@lru_cache(maxsize=512)
def _parsed(value: str) -> Any:
    from omegaconf.grammar_parser import parse

    return parse(value)


@contextlib.contextmanager
def _composed_once(argv: Sequence[str]) -> Iterator[None]:
    """Spare Hydra what it composes or copies only to find nothing in it, or for a task that is called.

    `hydra.mode` can be set by nothing but `-m`, a named sweep, a user's own files or overrides of Hydra's settings; a
    map of all choices is for defaults that refer to others. Before a sweep, Hydra composes its own settings with the
    default world. The world of a condition need not have the same settings, so only the conditions take the others.
    """
    from hydra._internal import defaults_list
    from hydra._internal.config_loader_impl import ConfigLoaderImpl
    from hydra._internal.hydra import Hydra
    from hydra.types import RunMode

    choices = defaults_list._create_interpolation_map
    apply, load = ConfigLoaderImpl._apply_overrides_to_config, ConfigLoaderImpl.load_configuration

    def apply_to_hydra(overrides: Any, config: Any) -> None:
        apply([override for override in overrides if override.is_hydra_override()], config)

    def loaded(self: Any, config_name: str, overrides: list[str], run_mode: RunMode, **options: Any) -> Any:
        used = apply_to_hydra if run_mode is RunMode.MULTIRUN else apply
        with _instead(ConfigLoaderImpl, "_apply_overrides_to_config", used):
            return load(self, config_name, overrides, run_mode, **options)

    def hand_over(self: Any, config_name: str, task_function: Collector, overrides: list[str]) -> None:
        task_function(self.compose_config(config_name, overrides, RunMode.RUN, with_log_configuration=True))

    def choices_referred_to(overrides: Any, defaults: list[Any], self_added: bool) -> Any:
        return choices(overrides, defaults, self_added) if any(one.is_interpolation() for one in defaults) else None

    may_set_mode = any(arg.lstrip("+~").startswith(("sweep", "hydra", "--config", "-c")) for arg in argv)
    mode = Hydra.get_mode if may_set_mode else lambda self, config_name, overrides: None
    with (
        _instead(Hydra, "get_mode", mode),
        _instead(Hydra, "run", hand_over),
        _instead(ConfigLoaderImpl, "load_configuration", loaded),
        _instead(defaults_list, "_create_interpolation_map", choices_referred_to),
    ):
        yield


@contextlib.contextmanager
def _files_read(defaults: Defaults) -> Iterator[None]:
    """Check each file of a user's own before Hydra reads it, which knows no bounds, and put the user's defaults in."""
    from hydra.core.plugins import Plugins
    from omegaconf import OmegaConf, _utils

    Plugins.instance()  # runs the modules of Hydra's sources again: only from now on they have the classes it uses
    from hydra._internal.core_plugins.file_config_source import FileConfigSource

    kept, shipped = FileConfigSource.load_config, paths.conf_dir()
    loader = _on_libyaml(_utils.get_yaml_loader())

    def read(self: Any, config_path: str) -> Any:
        file = Path(self.path) / self._normalize_file_name(config_path)
        is_own = Path(self.path) != shipped
        if is_own and file.is_file():
            check_config(file)
        found = kept(self, config_path) if is_own or not file.is_file() else _copy_of(self, config_path, file, kept)
        if not defaults.is_empty and self.scheme() == "file":
            content: Any = OmegaConf.to_container(found.config, resolve=False)
            if isinstance(content, dict) and defaults.put_into(
                content, config_path.removesuffix(".yaml"), found.header["package"]
            ):
                found.config = OmegaConf.create(content)
        return found

    with _instead(FileConfigSource, "load_config", read), _instead(_utils, "get_yaml_loader", lambda: loader):
        yield


def _copy_of(source: Any, config_path: str, file: Path, read: Callable[[Any, str], Any]) -> Any:
    """Return what a shipped file holds, for Hydra to change; unless it was written anew, it is read once a process."""
    kind: Any = type(source)
    found = _shipped(read, kind, source.provider, source.path, config_path, file.stat().st_mtime_ns)
    return replace(found, config=deepcopy(found.config), header=dict(found.header))


@lru_cache(maxsize=512)
def _shipped(read: Callable[[Any, str], Any], kind: Any, provider: str, path: str, name: str, written: int) -> Any:
    return read(kind(provider, path), name)


def _on_libyaml(loader: Any) -> Any:
    """Return a loader of YAML on libyaml's parser, which is several times as fast, where that is installed."""
    import yaml

    parser = getattr(yaml, "CSafeLoader", None)
    return loader if parser is None else type("Loader", (parser, loader), {})


def _composed(argv: Sequence[str], collector: Collector, defaults: Defaults) -> Composed:
    composed = [(one, _plain(one.config)) for one in collector.conditions]
    names, left_out = _worlds_left_out(argv, [config for _, config in composed])
    composed = [(one, config) for one, config in composed if not names or config["world"]["name"] not in names]
    collected, plain = zip(*composed, strict=True)
    keys = _swept_keys([one.overrides for one in collected])
    conditions = [
        condition for one, config in composed for condition in _conditions(one.config, config, keys, one.seeds)
    ]
    settings = {key: value for key, value in plain[0].items() if key not in (*CONDITION_KEYS, *_TAKEN_UP)}
    settings["record"] = plain[0]["record"]
    used = defaults.in_effect(collector.said(argv), plain, [one.choices for one in collected])
    return Composed(
        asked=(*deciding(used), *argv),
        conditions=tuple(conditions),
        settings=checked_settings(settings),
        first=collected[0].config,
        launch=collector.launch,
        defaults=used,
        choices=collected[0].choices,
        left_out=left_out,
    )


def _worlds_left_out(argv: Sequence[str], configs: Sequence[Mapping[str, Any]]) -> tuple[frozenset[str], str]:
    """Return the worlds that a named sweep chose and that need a missing package, and one line on them."""
    if not any(arg.startswith("+sweep=") for arg in argv) or "world" in overridden(argv):
        return frozenset(), ""
    from foundry.composing.preflight import worlds_left_out

    for config in configs:
        check_parts(config)
    return worlds_left_out(configs)


def _plain(config: Any, seed: Any = None, needed: Sequence[str] = ()) -> dict[str, Any]:
    """Return the configuration without Hydra's part, or what is needed of it, interpolations resolved."""
    from omegaconf import OmegaConf, open_dict

    keys = [key for key in config if key != "hydra"]
    if seed is not None:
        config = OmegaConf.masked_copy(config, keys)
        with open_dict(config):
            config.seed = seed

    def value(found: Any) -> Any:
        if not OmegaConf.is_config(found):
            return found
        return OmegaConf.to_container(found, resolve=True, throw_on_missing=True)

    return {str(key): value(config[key]) for key in needed or keys}


def _conditions(
    source: Any, config: dict[str, Any], keys: Sequence[str], asked_seeds: Sequence[Any]
) -> list[Condition]:
    """Return the condition with all its seeds, or one a seed where the configuration refers to the seed."""
    check_parts(config)
    seeds = tuple(_seed("seed", seed) for seed in (asked_seeds or [config["seed"]]))
    config["sampling_seed"] = _sampling_seed(config["sampling_seed"])
    probe = _plain(source, seed=seeds[0] + 1, needed=CONDITION_KEYS)
    if _parts(probe) == _parts(config):
        return [_condition(config, keys, seeds)]
    return [_condition(_plain(source, seed=seed), keys, (seed,)) for seed in seeds]


def _condition(config: dict[str, Any], keys: Sequence[str], seeds: tuple[int, ...]) -> Condition:
    return Condition(factors={key: _value(config, key) for key in keys}, config=_parts(config), seeds=seeds)


def _parts(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a condition is made of; of baselines only those that are chosen."""
    kept = {key: with_public_names(config[key]) for key in CONDITION_KEYS}
    return {key: value for key, value in kept.items() if key != "baselines" or value is not None}


def _swept_keys(overrides: Sequence[Sequence[str]]) -> list[str]:
    """Return the overrides that take more than one value over the sweep, in their order."""
    values: dict[str, set[str]] = {}
    for condition in overrides:
        for override in condition:
            key, _, value = override.partition("=")
            values.setdefault(key.lstrip("+"), set()).add(value)
    swept = [key for key, found in values.items() if len(found) > 1]
    for key in swept:
        if re.split(r"[.@/]", key)[0] not in _SWEPT_ONLY:
            raise InputError(
                f"'{key}' cannot be swept, since it does not change what a run is: "
                f"give it one value. Swept can be: seed, {', '.join(_SWEPT_ONLY)} and the keys below them."
            )
    return swept


def _value(config: Mapping[str, Any], key: str) -> Any:
    """Return the value of a swept key in a composed configuration; a group's is its name."""
    if key == FORMAT:
        return format_of(config["prompt"])
    value: Any = config
    for part in key.partition("@")[2].split(".") if "@" in key else key.split("."):
        value = value[part] if isinstance(value, Mapping) else value[int(part)]
    if isinstance(value, Mapping):
        return value.get("name", value.get("_target_", str(value)))
    return value


def _seed(name: str, value: Any) -> int:
    text = str(value)
    if isinstance(value, bool) or not re.fullmatch(r"\d{1,18}", text):
        raise InputError(f"{name}={text} is not a seed: give a whole number from 0, or -m {name}=0-9 for a range.")
    return int(text)


def _sampling_seed(value: Any) -> int | None:
    return None if value is None else _seed("sampling_seed", value)


def _explained(error: Exception, argv: Sequence[str]) -> InputError:
    """Return the one line that says what was wrong with the command line."""
    from hydra.errors import MissingConfigException, OverrideParseException
    from omegaconf.errors import MissingMandatoryValue

    message = str(error)
    if isinstance(error, MissingConfigException) and error.missing_cfg_file:
        return _unknown_config(error.missing_cfg_file, error.options or ())
    if isinstance(error, OverrideParseException):
        if Path(str(error.override)).is_dir():
            return InputError(f"'{error.override}' is a folder: name it as output.dir={error.override}")
        return InputError(f"'{error.override}' cannot be read: write key=value, and quote a value with signs in it.")
    if "add --multirun" in message or "Ambiguous value" in message:
        asked = re.search(r"'([^']*)'", message)
        return InputError(f"'{asked[1] if asked else ''}' names several values: add -m to run them all.")
    causes = " ".join(str(cause) for cause in (error, error.__cause__) if cause is not None)
    if isinstance(error, MissingMandatoryValue):
        return _open_setting(str(error.full_key))
    if there := re.search(r"An item is already at '([^']*)'", causes):
        return InputError(f"Setting '{there[1]}' exists already: leave out the + before it.")
    key = re.search(r"full_key: (\S+)", causes)
    if key and ("not in struct" in causes or "Could not override" in causes):
        return _unknown_key(key[1], argv)
    return InputError(" ".join(message.split()))


def _open_setting(key: str) -> InputError:
    """Return the error for a setting that its file leaves open; a backend's is filled by what follows its name."""
    group, _, name = key.rpartition(".")
    way = f"write {group}=<backend>/<{name}>, or" if group == "model" else "give it a value:"
    return InputError(f"{key} has no value: {way} {key}=...")


def _unknown_config(file: str, options: Sequence[str]) -> InputError:
    """Return the error for a config of a group that does not exist, with those that do."""
    group, _, name = file.rpartition("/")
    if "/" not in group:
        listed = options or [path.stem for path in (paths.conf_dir() / group).glob("*.yaml")]
        return not_found(group.capitalize() or "Config", name, listed)
    if group == "hydra/launcher":
        return not_found("Launcher", name, options, "More come as packages: pip install hydra-submitit-launcher")
    kind, _, folder = group.partition("/")
    shipped = [f"{folder}/{path.stem}" for path in (paths.conf_dir() / group).glob("*.yaml")]
    return not_found(kind.capitalize(), f"{folder}/{name}", shipped)


def _unknown_key(key: str, argv: Sequence[str]) -> InputError:
    """Return the error for a setting that no condition has, or not each, with those that do exist beside it."""
    groups = _groups()
    asked = {arg: arg.lstrip("+").partition("=")[0] for arg in argv}
    rest = [
        arg
        for arg in argv
        if asked[arg] in groups
        or not (f"{asked[arg]}.".startswith(f"{key}.") or f"{key}.".startswith(f"{asked[arg]}."))
    ]
    siblings: list[str] = []
    with contextlib.suppress(FoundryError):
        composed = compose(rest) if len(rest) < len(argv) else None
        if composed is not None:
            configs = [{**composed.settings, **one.config, "seed": 0} for one in composed.conditions]
            lacking = [config for config in configs if key not in _siblings(config, key)]
            if 0 < len(lacking) < len(configs):
                return _lacking(key, configs, lacking[0])
            siblings = _siblings(configs[0], key)
    return not_found("Setting", key, siblings, "To add a key of your own, write +key=value.")


def _lacking(key: str, configs: Sequence[Mapping[str, Any]], config: Mapping[str, Any]) -> InputError:
    """Return the error for a setting that some conditions have and this one lacks."""
    role = key.partition(".")[0]
    having = next(one for one in configs if key in _siblings(one, key))
    return InputError(
        f"{role.capitalize()} '{config[role]['name']}' has no setting '{key}', which {role} '{having[role]['name']}' "
        f"has. Run them in two commands, or leave the setting out."
    )


def _siblings(config: Mapping[str, Any], key: str) -> list[str]:
    """Return the settings that stand beside a place where one was looked for."""
    parents = key.split(".")[:-1]
    value: Any = config
    for part in parents:
        if not isinstance(value, Mapping) or part not in value:
            return []
        value = value[part]
    prefix = ".".join(parents) + "." if parents else ""
    return [f"{prefix}{name}" for name in value if name != "_target_"] if isinstance(value, Mapping) else []
