"""Lets Hydra compose the conditions of a command line, and turns Hydra's errors into one clear line."""

import argparse
import contextlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from foundry import own_code, paths
from foundry.composing.defaults import Defaults
from foundry.composing.names import check_own_names, with_public_names
from foundry.composing.points import Launch, Point, points_of, show
from foundry.composing.settings import check_parts, check_settings_of_hydra, checked_settings
from foundry.errors import FoundryError, InputError, not_found
from foundry.expansion import FORMAT, Condition, Sweep, expand, has_range, leaves, named_formats, overridden
from foundry.naming import format_of
from foundry.texts import one_line

CONDITION_KEYS = ("world", "model", "prompt", "sampling_seed", "record", "baselines")
"""Keys of a composed configuration that define a condition; the other keys say where and how to run."""
_TAKEN_UP = ("seed", "schema")
"""Further keys, which do not remain in a condition: `seed` becomes runs, and `schema` becomes a part of the model."""

_SWEPT_ONLY = ("world", "model", "prompt", "format", "layout", "scene", "task", "sampling_seed")
_MULTIRUN = ("-m", "--multirun")
_INFO = ("all", "config", "defaults", "defaults-tree", "plugins", "searchpath")


@dataclass(frozen=True)
class Composed:
    """The conditions and settings that a command line asks for.

    Attributes:
        asked: the command line, with the choices of the user's own defaults that apply; `sweep.yaml` records it.
        conditions: the conditions of the sweep, each with its seeds.
        settings: the keys that say where and how to run: cache, record, output, runner, analyze.
        first: the configuration that Hydra composed for the first condition.
        launch: function that runs jobs by one of Hydra's launchers; None if no launcher is named.
        defaults: the user's own defaults.
        chosen: the choices of these defaults that apply, as overrides.
        choices: the chosen option of each group in the first condition.
        left_out: a sentence on the worlds of a named sweep that need a missing package; "" if none do.
    """

    asked: tuple[str, ...]
    conditions: tuple[Condition, ...]
    settings: Mapping[str, Any]
    first: Any
    launch: Launch | None = None
    defaults: Defaults = Defaults()
    chosen: tuple[str, ...] = ()
    choices: Mapping[str, str] = field(default_factory=dict)
    left_out: str = ""

    @property
    def sweep(self) -> Sweep:
        """The sweep with all its runs."""
        return expand(self.asked, self.conditions)

    @property
    def multirun(self) -> str:
        """Hydra's configuration for the first condition, as YAML with unresolved references."""
        from omegaconf import OmegaConf

        return OmegaConf.to_yaml(self.first, resolve=False)


def compose(argv: Sequence[str], defaults: Defaults | None = None, folders: Sequence[Path] = ()) -> Composed | None:
    """Make the conditions of a sweep from the arguments of the command `foundry`.

    Returns:
        The conditions; None if Hydra answered one of its own flags (`--cfg`, `--info`, `--hydra-help`) instead.
    """
    argv = [named_formats(arg) for arg in own_code.folders_last(argv)]
    flags, overrides = _flags_and_overrides(argv)
    check_settings_of_hydra(overrides)
    own_code.use(own_code.config_dirs(argv))
    check_own_names(own_code.own_folders())
    from hydra.errors import HydraException
    from omegaconf.errors import OmegaConfBaseException

    defaults = defaults or Defaults()
    try:
        _check_groups(overrides)
        own = _existing_folders(argv)
        if set(flags).isdisjoint(_MULTIRUN) and flags:
            show(flags, overrides, own, folders, defaults)
            return None
        points, launch = points_of(overrides, own, folders, defaults, multirun=bool(flags))
        return _composed(argv, points, launch, defaults)
    except FoundryError:
        raise
    except (HydraException, OmegaConfBaseException) as error:
        raise InputError(f"{_explained(error, argv, folders)}{defaults.hint(str(error))}") from error
    except RecursionError as error:  # Hydra raises this if files include each other in a cycle
        raise InputError(
            "A configuration file includes itself, perhaps by way of others. Correct `defaults` in your own files."
        ) from error


def _flags_and_overrides(argv: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split a command line into flags with their values, without --config-dir, and overrides."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    parser.add_argument("overrides", nargs="*")
    parser.add_argument(*_MULTIRUN, "--hydra-help", "--resolve", action="store_true")
    parser.add_argument(*own_code.CONFIG_DIR)
    parser.add_argument("--package", "-p")
    parser.add_argument("--cfg", "-c", choices=("job", "hydra", "all"))
    parser.add_argument("--info", "-i", nargs="?", choices=_INFO)
    try:
        known, unknown = parser.parse_known_intermixed_args(argv)
    except argparse.ArgumentError as error:
        raise InputError(f"{error}. The command with --help lists its options.") from error
    if unknown:
        raise InputError(f"Unknown option '{unknown[0]}'. The command with --help lists its options.")
    folders = 2 * len(list(own_code.config_dirs(argv)))
    flags = [arg for arg in argv[: len(argv) - folders] if arg not in known.overrides]
    multirun = [flag for flag in flags if flag in _MULTIRUN]
    if multirun and len(flags) > len(multirun):
        raise InputError("--cfg and --info show one run: leave out -m.")
    ranges = [arg for arg in argv if has_range(arg)]
    if ranges and not multirun and not any(arg.startswith("+sweep=") for arg in argv):
        raise InputError(f"'{ranges[0]}' asks for several runs. Add -m, as in: foundry -m {' '.join(argv)}")
    return flags, known.overrides


def _existing_folders(argv: Sequence[str]) -> list[Path]:
    folders = [folder.absolute() for folder in own_code.config_dirs(argv)]
    for folder in folders:
        if not folder.is_dir():
            raise InputError(f"Folder '{folder}' not found. --config-dir names the folder with your parts.")
    return folders


def _check_groups(argv: Sequence[str]) -> None:
    """Reject a number as the name of an option, as in `world=7`; Hydra would print a traceback."""
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.core.override_parser.types import Override, QuotedString, Transformer

    def names(override: Override) -> list[Any]:
        value = override.value()
        swept = override.sweep_iterator(Transformer.identity) if override.is_sweep_override() else [value]
        return [name for chosen in swept for name in (chosen if isinstance(chosen, list) else [chosen])]

    groups = _shipped_groups()
    chosen = [arg for arg in argv if "=" in arg and arg.lstrip("+").partition("=")[0] in groups]
    for override in OverridesParser.create().parse_overrides(chosen):
        if not all(isinstance(name, str | QuotedString) for name in names(override)):
            group = str(override.key_or_group)
            options = (file.stem for file in (paths.conf_dir() / group).glob("*.yaml"))
            raise not_found(group.capitalize(), override.get_value_string(), options)


def _composed(argv: Sequence[str], points: Sequence[Point], launch: Launch | None, defaults: Defaults) -> Composed:
    composed = [(point, _plain(point.config)) for point in points]
    names, left_out = _worlds_left_out(argv, [config for _, config in composed])
    composed = [(point, config) for point, config in composed if not names or config["world"]["name"] not in names]
    points, configs = zip(*composed, strict=True)
    keys = _swept_keys([point.overrides for point in points])
    conditions = [condition for point, config in composed for condition in _conditions(point, config, keys)]
    settings = {key: value for key, value in configs[0].items() if key not in (*CONDITION_KEYS, *_TAKEN_UP)}
    settings["record"] = configs[0]["record"]
    given = overridden([*argv, *(override for point in points for override in point.overrides)])
    given |= {"seed"} if any(point.seeds for point in points) else set()
    conditions = [replace(condition, config=defaults.put_into(condition.config, given)) for condition in conditions]
    chosen = defaults.chosen(given, [point.choices for point in points])
    return Composed(
        asked=(*chosen, *argv),
        conditions=tuple(conditions),
        settings=checked_settings(defaults.put_into(settings, given)),
        first=points[0].config,
        launch=launch,
        defaults=defaults,
        chosen=chosen,
        choices=points[0].choices,
        left_out=left_out,
    )


def _shipped_groups() -> set[str]:
    return {folder.name for folder in paths.conf_dir().iterdir() if folder.is_dir()}


def _worlds_left_out(argv: Sequence[str], configs: Sequence[Mapping[str, Any]]) -> tuple[frozenset[str], str]:
    if not any(arg.startswith("+sweep=") for arg in argv) or "world" in overridden(argv):
        return frozenset(), ""
    from foundry.composing.preflight import worlds_left_out

    for config in configs:
        check_parts(config)
    return worlds_left_out(configs)


def _plain(config: Any, needed: Sequence[str] = ()) -> dict[str, Any]:
    from omegaconf import OmegaConf

    return {
        str(key): OmegaConf.to_container(config[key], resolve=True, throw_on_missing=True)
        if OmegaConf.is_config(config[key])
        else config[key]
        for key in needed or config
    }


def _conditions(point: Point, config: dict[str, Any], keys: Sequence[str]) -> list[Condition]:
    """Return one condition with all seeds; if settings depend on the seed, return one condition per seed."""
    check_parts(config)
    seeds = tuple(_seed("seed", seed) for seed in (point.seeds or [config["seed"]]))
    if config["sampling_seed"] is not None:
        config["sampling_seed"] = _seed("sampling_seed", config["sampling_seed"])
    if _parts(_plain(_with_seed(point.config, seeds[0] + 1), CONDITION_KEYS)) == _parts(config):
        return [_condition(config, keys, seeds)]
    return [_condition(_plain(_with_seed(point.config, seed)), keys, (seed,)) for seed in seeds]


def _with_seed(config: Any, seed: int) -> Any:
    config = config.copy()
    config.seed = seed
    return config


def _condition(config: dict[str, Any], keys: Sequence[str], seeds: tuple[int, ...]) -> Condition:
    return Condition(factors={key: _value(config, key) for key in keys}, config=_parts(config), seeds=seeds)


def _parts(config: Mapping[str, Any]) -> dict[str, Any]:
    parts = {key: with_public_names(config[key]) for key in CONDITION_KEYS}
    return {key: value for key, value in parts.items() if key != "baselines" or value is not None}


def _swept_keys(overrides: Sequence[Sequence[str]]) -> list[str]:
    values: dict[str, set[str]] = {}
    for condition in overrides:
        for override in condition:
            key, _, value = override.partition("=")
            values.setdefault(key.lstrip("+"), set()).add(value)
    swept = [key for key, levels in values.items() if len(levels) > 1]
    for key in swept:
        if re.split(r"[.@/]", key)[0] not in _SWEPT_ONLY:
            raise InputError(
                f"'{key}' cannot have several values, since it does not change the behaviour in a run. You can sweep "
                f"seed, {', '.join(_SWEPT_ONLY)} and the keys below them."
            )
    return swept


def _value(config: Mapping[str, Any], key: str) -> Any:
    """Return the value of a swept key in a configuration. For the key of a group, `world`, return the world's name."""
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
        raise InputError(f"{name}={text} is not a seed. Use a whole number from 0, or -m {name}=0-9 for a range.")
    return int(text)


def _explained(error: Exception, argv: Sequence[str], folders: Sequence[Path]) -> InputError:
    from hydra.errors import MissingConfigException, OverrideParseException
    from omegaconf.errors import MissingMandatoryValue

    message = str(error)
    if isinstance(error, MissingConfigException) and error.missing_cfg_file:
        return _unknown_config(error.missing_cfg_file, error.options or ())
    if isinstance(error, OverrideParseException):
        if Path(str(error.override)).is_dir():
            return InputError(f"'{error.override}' is a folder. To write into it, use output.dir={error.override}")
        return InputError(
            f"'{error.override}' cannot be read. Write key=value, with quotes around a value with special characters."
        )
    if "add --multirun" in message or "Ambiguous value" in message:
        quoted = re.search(r"'([^']*)'", message)
        return InputError(f"'{quoted[1] if quoted else ''}' has several values. Add -m to run them all.")
    causes = " ".join(str(cause) for cause in (error, error.__cause__) if cause is not None)
    if isinstance(error, MissingMandatoryValue):
        return _open_setting(str(error.full_key))
    if there := re.search(r"An item is already at '([^']*)'", causes):
        return InputError(f"Setting '{there[1]}' exists already. Leave out the + before it.")
    key = re.search(r"full_key: (\S+)", causes)
    if key and ("not in struct" in causes or "Could not override" in causes):
        return _unknown_key(key[1], argv, folders)
    return InputError(one_line(message))


def _open_setting(key: str) -> InputError:
    """Return the error for a setting without a value. For a model, the error names two ways to give this value."""
    group, _, name = key.rpartition(".")
    way = f"write {group}=<backend>/<{name}>, or" if group == "model" else "give it a value:"
    return InputError(f"{key} has no value: {way} {key}=...")


def _unknown_config(file: str, options: Sequence[str]) -> InputError:
    group, _, name = file.rpartition("/")
    if "/" not in group:
        listed = options or [path.stem for path in (paths.conf_dir() / group).glob("*.yaml")]
        return not_found(group.capitalize() or "Config", name, listed)
    if group == "hydra/launcher":
        return not_found("Launcher", name, options, "More come as packages: pip install hydra-submitit-launcher")
    kind, _, folder = group.partition("/")
    shipped = [f"{folder}/{path.stem}" for path in (paths.conf_dir() / group).glob("*.yaml")]
    return not_found(kind.capitalize(), f"{folder}/{name}", shipped)


def _unknown_key(key: str, argv: Sequence[str], folders: Sequence[Path]) -> InputError:
    groups = _shipped_groups()
    keys = {arg: arg.lstrip("+").partition("=")[0] for arg in argv}
    rest = [
        arg
        for arg in argv
        if keys[arg] in groups or not (f"{keys[arg]}.".startswith(f"{key}.") or f"{key}.".startswith(f"{keys[arg]}."))
    ]
    siblings: list[str] = []
    with contextlib.suppress(FoundryError):
        composed = compose(rest, folders=folders) if len(rest) < len(argv) else None
        if composed is not None:
            configs = [{**composed.settings, **condition.config, "seed": 0} for condition in composed.conditions]
            lacking = [config for config in configs if key not in _siblings(config, key)]
            if 0 < len(lacking) < len(configs):
                return _lacking(key, configs, lacking[0])
            siblings = [*_siblings(configs[0], key), *_deeper(configs[0], key)]
    return not_found("Setting", key, siblings, "To add a key of your own, write +key=value.")


def _lacking(key: str, configs: Sequence[Mapping[str, Any]], config: Mapping[str, Any]) -> InputError:
    role = key.partition(".")[0]
    having = next(config for config in configs if key in _siblings(config, key))
    return InputError(
        f"{role.capitalize()} '{config[role]['name']}' has no setting '{key}', which {role} '{having[role]['name']}' "
        f"has. Run the two {role}s in separate commands, or leave the setting out."
    )


def _siblings(config: Mapping[str, Any], key: str) -> list[str]:
    """Return the settings beside a missing one: for `world.agent`, the settings directly below `world`."""
    parents = key.split(".")[:-1]
    value: Any = config
    for part in parents:
        if not isinstance(value, Mapping) or part not in value:
            return []
        value = value[part]
    prefix = ".".join(parents) + "." if parents else ""
    return [f"{prefix}{name}" for name in value if name != "_target_"] if isinstance(value, Mapping) else []


def _deeper(config: Mapping[str, Any], key: str) -> list[str]:
    """Return the settings with a missing one's last word: for `model.temperature`, `model.options.temperature`."""
    group, word = key.split(".")[0], key.split(".")[-1]
    return [path for path, _ in leaves(config.get(group), group) if path.endswith(f".{word}")]
