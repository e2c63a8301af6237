"""Serves configs that have no file in a config folder: any model tag, and the named sweeps of `sweeps/`.

`hydra.searchpath` in `conf/config.yaml` names both sources. Its entries come after every folder, even after those of
`--config-dir`, so that real files take precedence. A `SearchPathPlugin` would put the sources before `--config-dir`.
"""

import re
from copy import deepcopy
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import Any

from hydra.core.object_type import ObjectType
from hydra.plugins.config_source import ConfigLoadError, ConfigResult, ConfigSource
from omegaconf import OmegaConf

from foundry import paths
from foundry.errors import InputError
from foundry.storing.plain import read_config

DEFAULT_BACKEND = "ollama"
DEFAULT_TAG = ":latest"
"""The tag that the default backend assumes if a name has none; it is removed, so that a model has only one name."""
_PACKAGE = re.compile(r"^\s*#\s*@package\s+(\S+)", re.MULTILINE)


def split_tag(config_path: str) -> tuple[str, str] | None:
    """Return (backend's config, model tag) of `model/<tag>`, or None if no backend serves it.

    A tag of the default backend is returned without `:latest`, which is the default. `conf/model/<backend>.yaml`, if it
    exists, serves `model/<backend>/<tag>`. If the first part is a folder of `conf/model`, only real files are served.
    Every other tag goes to the default backend.
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
    """Return the setting that a tag fills: the setting that the backend's file leaves open (`???`), else `name`."""
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
        # Each folder in a tag would become part of the package (model.hf.co...), so the package is set to the group.
        config = OmegaConf.create({"defaults": [base, "_self_"], open_key(backend): tag})
        header = {"package": "model"} if depth else {"package": None}
        return ConfigResult(config=config, path=f"{self.scheme()}://", provider=self.provider, header=dict(header))


class FolderSource(ConfigSource):
    """Serves the files of a folder, and checks each before it is read, since Hydra's own source has no limits."""

    @staticmethod
    def scheme() -> str:
        """Return the scheme of this source in the search path."""
        return "foundry-folder"

    def _place(self, config_path: str) -> Path:
        return Path(self.path) / config_path

    def _file(self, config_path: str) -> Path:
        return self._place(f"{config_path.removesuffix('.yaml')}.yaml")

    def available(self) -> bool:
        """Return whether the folder exists."""
        return Path(self.path).is_dir()

    def is_group(self, config_path: str) -> bool:
        """Return whether there is such a folder."""
        return self._place(config_path).is_dir()

    def is_config(self, config_path: str) -> bool:
        """Return whether there is such a file."""
        return self._file(config_path).is_file()

    def list(self, config_path: str, results_filter: ObjectType | None) -> list[str]:
        """Return the names in a group."""
        names: list[str] = []
        for entry in self._place(config_path).iterdir():
            kind = ObjectType.GROUP if entry.is_dir() else ObjectType.CONFIG
            if results_filter in (None, kind) and (entry.is_dir() or entry.suffix == ".yaml"):
                names.append(entry.name.removesuffix(".yaml"))
        return sorted(names)

    def load_config(self, config_path: str) -> ConfigResult:
        """Return the content of a file."""
        file = self._file(config_path)
        config, package = _content(file, file.stat().st_mtime_ns)
        return ConfigResult(
            config=deepcopy(config), path=self.full_path(), provider=self.provider, header={"package": package}
        )


@lru_cache(maxsize=512)
def _content(file: Path, written: int) -> tuple[Any, str | None]:
    """Return the content of a file and its package; an unchanged file is read once per process."""
    read_config(file)  # Hydra's own reader has no limits
    package = _PACKAGE.search(file.read_text(encoding="utf-8"))
    return OmegaConf.load(file), package[1] if package else None


class NamedSweepSource(FolderSource):
    """Serves `+sweep=<name>` from the files of `sweeps/`."""

    def __init__(self, provider: str, path: str) -> None:
        super().__init__(provider, path)
        self.path = str(paths.sweeps_dir())

    @staticmethod
    def scheme() -> str:
        """Return the scheme of this source in the search path."""
        return "foundry-sweeps"

    def _place(self, config_path: str) -> Path:
        return Path(self.path) / config_path.removeprefix("sweep").removeprefix("/")
