"""From a command line to composed conditions, by Hydra; its errors become one clear line."""

from __future__ import annotations

import contextlib
import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from foundry import own_code, paths
from foundry.composing.collecting import Collector, Launch
from foundry.composing.public_names import with_public_names
from foundry.composing.settings import check_parts, checked_settings
from foundry.errors import FoundryError, InputError, not_found
from foundry.expansion import Condition, has_range
from foundry.storing.plain_yaml import check_config

CONDITION_KEYS = ("world", "model", "prompt", "sampling_seed", "record", "baselines")
"""What goes into a condition; the other keys say where and how it is run."""
_TAKEN_UP = ("seed", "schema")
"""What other parts of a configuration refer to or are multiplied by, and is nothing by itself."""

_SWEPT_ONLY = ("world", "model", "prompt", "layout", "scene", "task", "sampling_seed")
_MULTIRUN = ("-m", "--multirun")
CONFIG_DIR = ("-cd", "--config-dir")
"""How a user's own folder of configurations is named."""


@dataclass(frozen=True)
class Composed:
    """A composed command line.

    Attributes:
        asked: the overrides as given.
        conditions: the points of the sweep, each with its seeds.
        settings: the keys that say where and how to run: cache, record, output, runner, analyze.
        multirun: Hydra's configuration of the sweep as YAML.
        launch: has one of Hydra's own launchers call a function in a job for each list of overrides; None where
            none was asked for.
    """

    asked: tuple[str, ...]
    conditions: tuple[Condition, ...]
    settings: Mapping[str, Any]
    multirun: str
    launch: Launch | None = None


def compose(argv: Sequence[str]) -> Composed | None:
    """Compose a command line as `foundry` takes it.

    Returns:
        The conditions, or None when Hydra answered a flag of its own (`--cfg`, `--info`, `--hydra-help`).

    Raises:
        InputError: the command line asks for something that does not exist or cannot be read.
    """
    argv = folders_last(argv)
    _check_ranges(argv)
    own_code.use(config_dirs(argv))
    from hydra.errors import HydraException
    from omegaconf.errors import OmegaConfBaseException

    try:
        _check_groups(argv)
        collector = _run_hydra(argv)
        return _composed(argv, collector) if collector.conditions else None
    except FoundryError:
        raise
    except (HydraException, OmegaConfBaseException) as error:
        raise _explained(error, argv) from error


def _check_ranges(argv: Sequence[str]) -> None:
    is_sweep = any(arg in _MULTIRUN or arg.startswith("+sweep=") for arg in argv)
    ranges = [arg for arg in argv if has_range(arg)]
    if ranges and not is_sweep:
        raise InputError(f"'{ranges[0]}' asks for several runs: add -m, as in foundry -m {' '.join(argv)}")


def config_dirs(argv: Sequence[str]) -> Iterator[Path]:
    """Yield the user's own folders of configurations, in the forms that Hydra takes."""
    for flag, value in zip(argv, [*argv[1:], ""], strict=False):
        if flag in CONFIG_DIR:
            yield Path(value)
        elif flag.startswith("--config-dir="):
            yield Path(flag.partition("=")[2])


def folders_last(argv: Sequence[str]) -> list[str]:
    """Return the command line with the user's own folders behind all else, each as a flag and its value.

    Hydra reads no overrides that stand on both sides of a flag.
    """
    rest, folders = list(argv), list(config_dirs(argv))
    while flag := next((one for one in rest if one.partition("=")[0] in CONFIG_DIR), None):
        place = rest.index(flag)
        del rest[place : place + (1 if "=" in flag else 2)]
    return [*rest, *(part for folder in folders for part in (CONFIG_DIR[1], str(folder)))]


def _check_groups(argv: Sequence[str]) -> None:
    """Refuse a choice in a group of configurations that is no name; Hydra would end in a traceback."""
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.core.override_parser.types import Override, QuotedString, Transformer

    def names(override: Override) -> list[Any]:
        value = override.value()
        swept = override.sweep_iterator(Transformer.identity) if override.is_sweep_override() else [value]
        return [name for chosen in swept for name in (chosen if isinstance(chosen, list) else [chosen])]

    groups = {folder.name for folder in paths.conf_dir().iterdir() if folder.is_dir()}
    chosen = [arg for arg in argv if "=" in arg and arg.lstrip("+").partition("=")[0] in groups]
    for override in OverridesParser.create().parse_overrides(chosen):
        if not all(isinstance(name, str | QuotedString) for name in names(override)):
            group = str(override.key_or_group)
            options = (file.stem for file in (paths.conf_dir() / group).glob("*.yaml"))
            raise not_found(group.capitalize(), override.get_value_string(), options)


def _run_hydra(argv: Sequence[str]) -> Collector:
    """Let Hydra read the command line; nothing is run by it."""
    import hydra

    collector = Collector()
    with _hydra_surroundings(argv), _composed_once(argv), _files_checked():
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
def _composed_once(argv: Sequence[str]) -> Iterator[None]:
    """Spare Hydra what it composes only to look for `hydra.mode`, where nothing but `-m` can have set it.

    Named sweeps set it, and a user's own files or overrides of Hydra's settings may; `conf/` does not.
    """
    from hydra._internal.hydra import Hydra

    if any(arg.lstrip("+~").startswith(("sweep", "hydra", "--config", "-c")) for arg in argv):
        yield
        return
    kept = Hydra.get_mode
    Hydra.get_mode = lambda self, config_name, overrides: None  # type: ignore[method-assign]  # as if none was set
    try:
        yield
    finally:
        Hydra.get_mode = kept  # type: ignore[method-assign]


@contextlib.contextmanager
def _files_checked() -> Iterator[None]:
    """Check each file of a user's own before Hydra reads it, which knows no bounds; the rest stays unread."""
    from hydra._internal.core_plugins.file_config_source import FileConfigSource

    kept, shipped = FileConfigSource.load_config, paths.conf_dir()

    def checked(self: Any, config_path: str) -> Any:
        file = Path(self.path) / self._normalize_file_name(config_path)
        if Path(self.path) != shipped and file.is_file():
            check_config(file)
        return kept(self, config_path)

    FileConfigSource.load_config = checked  # type: ignore[method-assign]
    try:
        yield
    finally:
        FileConfigSource.load_config = kept  # type: ignore[method-assign]


def _composed(argv: Sequence[str], collector: Collector) -> Composed:
    from omegaconf import OmegaConf

    first = collector.conditions[0].config
    plain = [_plain(one.config) for one in collector.conditions]
    keys = _swept_keys([one.overrides for one in collector.conditions])
    conditions = [
        condition
        for one, config in zip(collector.conditions, plain, strict=True)
        for condition in _conditions(one.config, config, keys, one.seeds)
    ]
    settings = {key: value for key, value in plain[0].items() if key not in (*CONDITION_KEYS, *_TAKEN_UP)}
    settings["record"] = plain[0]["record"]
    return Composed(
        asked=tuple(argv),
        conditions=tuple(conditions),
        settings=checked_settings(settings),
        multirun=OmegaConf.to_yaml(first, resolve=False),
        launch=collector.launch,
    )


def _plain(config: Any, seed: Any = None) -> dict[str, Any]:
    """Return the configuration without Hydra's part, interpolations resolved."""
    from omegaconf import OmegaConf, open_dict

    if "hydra" in config:
        config = OmegaConf.masked_copy(config, [key for key in config if key != "hydra"])
    if seed is not None:
        with open_dict(config):
            config.seed = seed
    plain = OmegaConf.to_container(config, resolve=True, throw_on_missing=True)
    assert isinstance(plain, dict)
    return {str(key): value for key, value in plain.items()}


def _conditions(
    source: Any, config: dict[str, Any], keys: Sequence[str], asked_seeds: Sequence[Any]
) -> list[Condition]:
    """Return the condition with all its seeds, or one a seed where the configuration refers to the seed."""
    check_parts(config)
    seeds = tuple(_seed("seed", seed) for seed in (asked_seeds or [config["seed"]]))
    config["sampling_seed"] = _sampling_seed(config["sampling_seed"])
    probe = _plain(source, seed=seeds[0] + 1)
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
        return InputError(f"'{error.override}' cannot be read: write key=value, and quote a value with signs in it.")
    if "add --multirun" in message or "Ambiguous value" in message:
        asked = re.search(r"'([^']*)'", message)
        return InputError(f"'{asked[1] if asked else ''}' names several values: add -m to run them all.")
    causes = " ".join(str(cause) for cause in (error, error.__cause__) if cause is not None)
    if isinstance(error, MissingMandatoryValue):
        return _open_setting(str(error.full_key))
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
        return not_found(group.capitalize() or "Config", name, options)
    if group == "hydra/launcher":
        return not_found("Launcher", name, options, "More come as packages: pip install hydra-submitit-launcher")
    kind, _, folder = group.partition("/")
    shipped = [f"{folder}/{path.stem}" for path in (paths.conf_dir() / group).glob("*.yaml")]
    return not_found(kind.capitalize(), f"{folder}/{name}", shipped)


def _unknown_key(key: str, argv: Sequence[str]) -> InputError:
    """Return the error for a setting that does not exist, with those that do beside it."""
    rest = [arg for arg in argv if arg.lstrip("+").partition("=")[0] != key]
    siblings: list[str] = []
    with contextlib.suppress(FoundryError):
        composed = compose(rest) if len(rest) < len(argv) else None
        if composed is not None:
            siblings = _siblings({**composed.settings, **composed.conditions[0].config, "seed": 0}, key)
    return not_found("Setting", key, siblings, "To add a key of your own, write +key=value.")


def _siblings(config: Mapping[str, Any], key: str) -> list[str]:
    parents = key.split(".")[:-1]
    value: Any = config
    for part in parents:
        if not isinstance(value, Mapping) or part not in value:
            return []
        value = value[part]
    prefix = ".".join(parents) + "." if parents else ""
    return [f"{prefix}{name}" for name in value if name != "_target_"] if isinstance(value, Mapping) else []
