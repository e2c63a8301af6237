"""Lets Hydra compose each point of a grid, that is, each combination of the values of a sweep."""

import contextlib
import itertools
import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, TypeAlias

from foundry import paths
from foundry.composing.defaults import Defaults
from foundry.errors import InputError
from foundry.expansion import expand_ranges
from foundry.storing.plain import read_config
from foundry.storing.sweep_file import to_yaml

Launch: TypeAlias = Callable[[Callable[[Any], Any], Sequence[Sequence[str]]], Sequence[Any]]
"""A launcher of Hydra: it calls the given function once per list of overrides, and returns a `JobReturn` per call."""
PRIMARY = "config"
_OF_HYDRA = ("hydra.", "hydra/")
_SEARCHPATH = "hydra.searchpath="
_SEED = "seed="
_Composer: TypeAlias = Callable[[tuple[str, ...]], tuple[Any, Mapping[str, str]]]
"""Function that composes overrides; it returns a configuration, which must not be changed, and the chosen options."""


@dataclass(frozen=True)
class Point:
    """The configuration for one combination of the swept values.

    Attributes:
        config: the configuration, with unresolved references and without Hydra's part.
        choices: the chosen option of each group.
        overrides: the overrides of the point; empty if the command line asks for a single run.
        seeds: the seeds on the command line, as written; empty if it names none.
    """

    config: Any
    choices: Mapping[str, str]
    overrides: tuple[str, ...] = ()
    seeds: tuple[str, ...] = ()


def points_of(
    argv: Sequence[str], own: Sequence[Path], folders: Sequence[Path], defaults: Defaults, *, multirun: bool
) -> tuple[list[Point], Launch | None]:
    """Return the points of a grid, and the named launcher of Hydra as a function that runs jobs, or None."""
    import hydra
    from omegaconf import OmegaConf

    launch: Launch | None = None
    params: Mapping[str, Any] = {}
    with _folders(argv, own, folders, defaults) as (main, asked), _hydra_in(main):
        of_hydra = [arg for arg in asked if arg.lstrip("+~").startswith(_OF_HYDRA)]
        if multirun or of_hydra[1:] or any(arg.startswith("+") for arg in asked):
            config = hydra.compose(PRIMARY, overrides=_fixed_choices(asked), return_hydra_config=True)
            launch = None if OmegaConf.is_missing(config.hydra, "launcher") else partial(_launch, config)
            multirun = multirun or config.hydra.mode is not None
            params = config.hydra.sweeper.params or {}
        searches = any(arg.startswith(_SEARCHPATH) for arg in argv)
        is_shipped = defaults == Defaults() and not (own or folders or searches)
        composer = partial(_composed_of_shipped, _stamps()) if is_shipped else lru_cache(_composed)
        point_of = partial(_point, composer, _groups([paths.conf_dir(), *own, *folders]))
        if not multirun:
            return [point_of(asked)], launch
        grid = [*(f"{key}={value}" for key, value in params.items()), *(arg for arg in asked if arg not in of_hydra)]
        points = _grid(map(expand_ranges, grid))
        return [point_of([*of_hydra, *point], point, seeds) for point, seeds in points], launch


def show(
    flags: Sequence[str], argv: Sequence[str], own: Sequence[Path], folders: Sequence[Path], defaults: Defaults
) -> None:
    """Let Hydra process its own flags, such as `--cfg job`."""
    import hydra

    before = sys.argv, os.environ.get("HYDRA_FULL_ERROR")
    with _folders(argv, own, folders, defaults) as (main, asked):
        try:
            sys.argv, os.environ["HYDRA_FULL_ERROR"] = ["foundry", *flags, *asked], "1"
            hydra.main(version_base="1.3", config_path=str(main), config_name=PRIMARY)(lambda config: None)()
        finally:
            sys.argv = before[0]
            del os.environ["HYDRA_FULL_ERROR"]
            os.environ.update({} if before[1] is None else {"HYDRA_FULL_ERROR": before[1]})


@contextlib.contextmanager
def _folders(
    argv: Sequence[str], own: Sequence[Path], folders: Sequence[Path], defaults: Defaults
) -> Iterator[tuple[Path, list[str]]]:
    """Yield the folder of the primary configuration, and the overrides. The first override lists all other folders."""
    from hydra.core.override_parser.overrides_parser import OverridesParser

    asked = [arg for arg in argv if arg.startswith(_SEARCHPATH)][:1]
    primary = defaults.primary(read_config(paths.conf_dir() / f"{PRIMARY}.yaml"))
    sources: Any = primary["hydra"]["searchpath"]
    if asked:
        sources = OverridesParser.create().parse_override(asked[0]).value()
    if not isinstance(sources, list):
        raise InputError(f"hydra.searchpath must be a list; got '{sources}'. Write {_SEARCHPATH}[file:///FOLDER].")
    with tempfile.TemporaryDirectory() as main:
        Path(main, f"{PRIMARY}.yaml").write_text(to_yaml(primary), encoding="utf-8")
        files = [f"foundry-folder://{folder}" for folder in (paths.conf_dir(), *own, *folders)]
        quoted = ",".join(f'"{source}"' for source in (*files, *sources))
        yield Path(main), [f"{_SEARCHPATH}[{quoted}]", *(arg for arg in argv if arg not in asked)]


@contextlib.contextmanager
def _hydra_in(folder: Path) -> Iterator[None]:
    import hydra

    with hydra.initialize_config_dir(str(folder), job_name="foundry", version_base="1.3"):
        yield


def _point(
    composer: _Composer,
    groups: Set[str],
    overrides: Sequence[str],
    grid: Sequence[str] = (),
    seeds: Sequence[str] = (),
) -> Point:
    from omegaconf import OmegaConf
    from omegaconf.errors import OmegaConfBaseException

    choosing, settings = _choices_and_settings(overrides, groups)
    composed, choices = composer(tuple(choosing))
    config = composed.copy()
    try:
        for setting in settings:
            OmegaConf.update(config, setting.key_or_group, setting.value())
    except OmegaConfBaseException:
        config, choices = _composed(tuple(overrides))  # Hydra reports the error
    return Point(config, dict(choices), tuple(grid), tuple(seeds))


def _choices_and_settings(overrides: Sequence[str], groups: Set[str]) -> tuple[list[str], list[Any]]:
    """Split overrides into choices (as `world=bar`), which Hydra must compose, and parsed settings (as `seed=3`).

    Hydra applies settings in their order, after all choices. If there are overrides of any other kind, Hydra composes
    all overrides.
    """
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.core.override_parser.types import OverrideType

    choosing: list[str] = []
    settings: list[Any] = []
    for arg, override in zip(overrides, OverridesParser.create().parse_overrides(list(overrides)), strict=True):
        key, is_plain = override.key_or_group, not (override.is_sweep_override() or override.package)
        if override.is_hydra_override() or (
            key in groups and is_plain and not override.is_delete() and isinstance(override.value(), str)
        ):
            choosing.append(arg)
        elif is_plain and key not in groups and "/" not in key and override.type is OverrideType.CHANGE:
            settings.append(override)
        else:
            return list(overrides), []
    return choosing, settings


def _groups(folders: Sequence[Path]) -> set[str]:
    return {"sweep", *(entry.name for folder in folders for entry in folder.iterdir() if entry.is_dir())}


def _stamps() -> tuple[tuple[str, int, int, int], ...]:
    """Return a value that changes if any shipped configuration file changes."""
    stamps = []
    for top in (paths.conf_dir(), paths.sweeps_dir()):
        for folder, _, names in os.walk(top):
            for name in names:
                file = os.path.join(folder, name)
                with contextlib.suppress(FileNotFoundError):  # an editor's lock file may be a broken link
                    status = os.stat(file)
                    stamps.append((file, status.st_mtime_ns, status.st_ctime_ns, status.st_size))
    return tuple(stamps)


@lru_cache(maxsize=256)
def _composed_of_shipped(
    stamps: tuple[tuple[str, int, int, int], ...], overrides: tuple[str, ...]
) -> tuple[Any, Mapping[str, str]]:
    """Let Hydra compose shipped files only; the result is kept until a file changes."""
    return _composed(overrides)


def _composed(overrides: tuple[str, ...]) -> tuple[Any, Mapping[str, str]]:
    import hydra
    from omegaconf import open_dict

    config = hydra.compose(PRIMARY, overrides=list(overrides), return_hydra_config=True)
    choices = dict(config.hydra.runtime.choices)
    with open_dict(config):
        del config["hydra"]
    return config, choices


def _fixed_choices(asked: Sequence[str]) -> list[str]:
    """Return the overrides that Hydra needs to find its launcher: `hydra.*`, and choices such as `world=bar`.

    Other settings are left out, since perhaps not every world of the grid has them.
    """
    from hydra.core.override_parser.overrides_parser import OverridesParser

    parsed = OverridesParser.create().parse_overrides(list(asked))
    return [
        arg
        for arg, override in zip(asked, parsed, strict=True)
        if override.is_hydra_override() or not (override.is_sweep_override() or "." in override.key_or_group)
    ]


def _grid(overrides: Iterable[str]) -> Iterator[tuple[tuple[str, ...], list[str]]]:
    """Yield each combination of the overrides' values, with the seeds. The last override of each key applies."""
    from hydra.core.global_hydra import GlobalHydra
    from hydra.core.override_parser.overrides_parser import OverridesParser

    parser = OverridesParser.create(config_loader=GlobalHydra.instance().config_loader())
    axes: dict[str, list[str]] = {}
    for override in parser.parse_overrides(list(overrides)):
        key = override.get_key_element()
        if override.is_sweep_override():
            axes[key] = list(override.sweep_string_iterator())
        else:
            axes[key] = [override.get_value_element_as_str()]
    seeds = axes.pop("seed", [])
    for values in itertools.product(*axes.values()):
        yield tuple(f"{key}={value}" for key, value in zip(axes, values, strict=True)), seeds


def _launch(config: Any, task: Callable[[Any], Any], jobs: Sequence[Sequence[str]]) -> Sequence[Any]:
    from hydra.core.global_hydra import GlobalHydra
    from hydra.core.plugins import Plugins
    from hydra.experimental.callback import Callback
    from hydra.types import HydraContext

    nothing: Any = Callback()
    with _hydra_in(paths.conf_dir()):
        context = HydraContext(config_loader=GlobalHydra.instance().config_loader(), callbacks=nothing)
        launcher = Plugins.instance().instantiate_launcher(context, task, config)
        return launcher.launch(jobs, initial_job_idx=0)
