"""Configs that have no file in a config folder: any model tag, and the named sweeps of `sweeps/`.

`hydra.searchpath` in `conf/config.yaml` names both sources: entries from there come after every folder, those of
`--config-dir` too, so that real files win. A `SearchPathPlugin` would put them before `--config-dir`.
"""

from __future__ import annotations

import os
from pathlib import Path, PurePosixPath

from hydra._internal.core_plugins.file_config_source import FileConfigSource
from hydra.core.object_type import ObjectType
from hydra.plugins.config_source import ConfigLoadError, ConfigResult, ConfigSource
from omegaconf import OmegaConf

from foundry import paths
from foundry.errors import InputError

DEFAULT_BACKEND = "ollama"
DEFAULT_TAG = ":latest"
"""What the default backend takes where a name has no tag: with it or without, a model has one name, the short one."""


def split_tag(config_path: str) -> tuple[str, str] | None:
    """Return (backend's config, model tag) of `model/<tag>`, or None where no backend would serve it.

    A tag of the default backend is without `:latest`, which it stands for anyway. `model/<backend>/<tag>` is served
    by `conf/model/<backend>.yaml` if there is one; a first part that is a folder of `conf/model` holds real files
    only; every other tag goes to the default backend.

    Raises:
        InputError: a backend is named and nothing follows.
    """
    group, _, tag = config_path.removesuffix(".yaml").partition("/")
    if group != "model" or not tag:
        return None
    models = paths.conf_dir() / "model"
    first, slash, rest = tag.partition("/")
    if slash and not rest and (models / f"{first}.yaml").is_file():
        raise InputError(f"model={tag} names no model: write model={first}/<{open_key(first)}>.")
    if (models / f"{tag}.yaml").is_file() or (models / first).is_dir():
        return None
    backend, tag = (first, rest) if rest and (models / f"{first}.yaml").is_file() else (DEFAULT_BACKEND, tag)
    return backend, tag.removesuffix(DEFAULT_TAG) if backend == DEFAULT_BACKEND else tag


def open_key(backend: str) -> str:
    """Return the setting that a tag fills: the one that the backend's file leaves open (`???`), else `name`."""
    config = OmegaConf.load(paths.conf_dir() / "model" / f"{backend}.yaml")
    return next((str(key) for key in config if OmegaConf.is_missing(config, key)), "name")


class ModelTagSource(ConfigSource):
    """Serves `model=<any tag>` and `model=<backend>/<tag>` as the backend's config with the tag in its open key."""

    @staticmethod
    def scheme() -> str:
        """Return the scheme of this source in the search path."""
        return "foundry-models"

    def available(self) -> bool:
        """Return whether the source can be used."""
        return True

    def is_group(self, config_path: str) -> bool:
        """Return whether the path is a group of this source."""
        return config_path in ("", "model")

    def is_config(self, config_path: str) -> bool:
        """Return whether the path is a model tag."""
        return split_tag(config_path) is not None

    def list(self, config_path: str, results_filter: ObjectType | None) -> list[str]:
        """Return nothing: tags are not known in advance."""
        return []

    def load_config(self, config_path: str) -> ConfigResult:
        """Return the backend's config with the tag in its open key."""
        split = split_tag(config_path)
        if split is None:
            raise ConfigLoadError(f"Config not found : {config_path}")
        backend, tag = split
        depth = len(PurePosixPath(config_path).parts) - 2
        base = f"/model/{backend}@_here_" if depth else backend
        # Each folder in a tag would open a package of its own (model.hf.co...): pin the package to the group.
        config = OmegaConf.create({"defaults": [base, "_self_"], open_key(backend): tag})
        header = {"package": "model"} if depth else {"package": None}
        return ConfigResult(config=config, path=f"{self.scheme()}://", provider=self.provider, header=dict(header))


class NamedSweepSource(FileConfigSource):
    """Serves `+sweep=<name>` from the files of `sweeps/`."""

    def __init__(self, provider: str, path: str) -> None:
        super().__init__(provider, path)
        self.path = str(paths.sweeps_dir())

    @staticmethod
    def scheme() -> str:
        """Return the scheme of this source in the search path."""
        return "foundry-sweeps"

    def _inside(self, config_path: str) -> str | None:
        group, _, name = config_path.partition("/")
        return name if group == "sweep" else None

    def available(self) -> bool:
        """Return whether the folder of sweeps exists."""
        return os.path.isdir(self.path)

    def is_group(self, config_path: str) -> bool:
        """Return whether the path is the group `sweep`."""
        return config_path in ("", "sweep")

    def is_config(self, config_path: str) -> bool:
        """Return whether there is such a sweep."""
        name = self._inside(config_path)
        return bool(name) and super().is_config(str(name))

    def list(self, config_path: str, results_filter: ObjectType | None) -> list[str]:
        """Return the names of the sweeps."""
        if config_path == "":
            return [] if results_filter == ObjectType.CONFIG else ["sweep"]
        if results_filter == ObjectType.GROUP or not self.is_group(config_path):
            return []
        return sorted(file.stem for file in Path(self.path).glob("*.yaml"))

    def load_config(self, config_path: str) -> ConfigResult:
        """Return the content of a sweep's file."""
        name = self._inside(config_path)
        if not name:
            raise ConfigLoadError(f"Config not found : {config_path}")
        return super().load_config(name)
