"""Gives Hydra the configurations that are in no folder: model tags, drawn formats, mixes and named sweeps.

`hydra.searchpath` in `conf/config.yaml` names the sources. Its entries come after every folder, even after those of
`--config-dir`, so that real files take precedence. A `SearchPathPlugin` would put the sources before `--config-dir`.
"""

import re
from abc import abstractmethod
from collections.abc import Mapping
from copy import deepcopy
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import Any, ClassVar

from hydra.core.object_type import ObjectType
from hydra.plugins.config_source import ConfigLoadError, ConfigResult, ConfigSource
from omegaconf import OmegaConf

from foundry import paths
from foundry.errors import InputError
from foundry.storing.plain import read_config

DEFAULT_BACKEND = "ollama"
DEFAULT_TAG = ":latest"
"""The tag that the default backend assumes if a name has none; it is removed, so that a model has only one name."""
MIX = "model/mix/"
_MEMBER = re.compile(r"(?P<model>[^@+]+)@(?:(?P<share>[\d.]+%)|(?P<agents>\d+(?:-\d+)?)|(?P<persona>[^@+:]+:[^@+]+))")
_DRAWN = re.compile(r"format/(?P<space>[^/]+)/(?P<draw>\d{1,9})")
_PACKAGE = re.compile(r"^\s*#\s*@package\s+(\S+)", re.MULTILINE)


def split_tag(config_path: str) -> tuple[str, str] | None:
    """Split `model/<tag>` into the name of the backend and the model's tag; return None if no backend serves it.

    If `conf/model/<backend>.yaml` exists, it serves `model/<backend>/<tag>`. If the first part is a folder of
    `conf/model`, only real files are served. Every other tag goes to the default backend, without its `:latest`.
    """
    group, _, tag = config_path.removesuffix(".yaml").partition("/")
    if group != "model" or not tag:
        return None
    models = paths.conf_dir() / "model"
    first, slash, rest = tag.partition("/")
    if slash and not rest and (models / f"{first}.yaml").is_file():
        raise InputError(f"model={tag} does not say which model: write model={first}/<{open_key(first)}>.")
    if (models / f"{tag}.yaml").is_file() or (models / first).is_dir():
        return None
    backend, tag = (first, rest) if rest and (models / f"{first}.yaml").is_file() else (DEFAULT_BACKEND, tag)
    return backend, tag.removesuffix(DEFAULT_TAG) if backend == DEFAULT_BACKEND else tag


def open_key(backend: str) -> str:
    """Return the key that gets a model's tag: the key that the backend's file leaves open (`???`), else `name`."""
    config = OmegaConf.load(paths.conf_dir() / "model" / f"{backend}.yaml")
    return next((str(key) for key in config if OmegaConf.is_missing(config, key)), "name")


class Source(ConfigSource):
    """A source with a fixed scheme, such as `foundry-models` for `foundry-models://` in the search path."""

    SCHEME: ClassVar[str]

    @classmethod
    def scheme(cls) -> str:
        """Return the scheme of this source in the search path."""
        return cls.SCHEME


class MadeSource(Source):
    """Makes a configuration from its name on the command line; so it cannot list the names."""

    GROUPS: ClassVar[tuple[str, ...]]

    @abstractmethod
    def make(self, config_path: str) -> tuple[Mapping[str, Any], str | None]:
        """Return the configuration, and the package (place in the whole configuration) into which Hydra puts it."""

    def available(self) -> bool:
        """Return whether the source can be used."""
        return True

    def is_group(self, config_path: str) -> bool:
        """Return whether the path is a group of this source."""
        return config_path in ("", *self.GROUPS)

    def list(self, config_path: str, results_filter: ObjectType | None) -> list[str]:
        """Return nothing: the names are not known in advance."""
        return []

    def load_config(self, config_path: str) -> ConfigResult:
        """Return the configuration with this name."""
        if not self.is_config(config_path):
            raise ConfigLoadError(f"Config not found : {config_path}")
        config, package = self.make(config_path.removesuffix(".yaml"))
        path, header = f"{self.scheme()}://", {"package": package}
        return ConfigResult(config=OmegaConf.create(dict(config)), path=path, provider=self.provider, header=header)


class ModelTagSource(MadeSource):
    """Serves `model=<any tag>` and `model=<backend>/<tag>` as the backend's config with the tag in its open key."""

    SCHEME = "foundry-models"
    GROUPS = ("model",)

    def is_config(self, config_path: str) -> bool:
        """Return whether the path is a model tag."""
        return split_tag(config_path) is not None

    def make(self, config_path: str) -> tuple[Mapping[str, Any], str | None]:
        """Return the backend's configuration with the tag in its open key."""
        split = split_tag(config_path)
        assert split is not None
        backend, tag = split
        is_deep = len(PurePosixPath(config_path).parts) > 2
        base = f"/model/{backend}@_here_" if is_deep else backend
        # Each folder in a tag would become part of the package (model.hf.co...), so the package is set to the group.
        return {"defaults": [base, "_self_"], open_key(backend): tag}, "model" if is_deep else None


class FormatSource(MadeSource):
    """Serves `format=<space>/<number>`, such as `format=spread/3`, as the space's file with the number of the draw."""

    SCHEME = "foundry-formats"
    GROUPS = ("format",)

    def is_config(self, config_path: str) -> bool:
        """Return whether the path is a drawn format."""
        return _DRAWN.fullmatch(config_path.removesuffix(".yaml")) is not None

    def make(self, config_path: str) -> tuple[Mapping[str, Any], str | None]:
        """Return the space with the number of the draw."""
        space, draw = config_path.split("/")[1:]
        return {"defaults": [f"/format/{space}@_here_", "_self_"], "draw": int(draw)}, "prompt.format"


class MixSource(MadeSource):
    """Serves populations such as `model=mix/qwen3:4b@50%+llama3.2@50%`; each model may be any that `model=` accepts."""

    SCHEME = "foundry-mixes"
    GROUPS = ("model", MIX.rstrip("/"))

    def is_config(self, config_path: str) -> bool:
        """Return whether the path is a population."""
        return config_path.startswith(MIX)

    def make(self, config_path: str) -> tuple[Mapping[str, Any], str | None]:
        """Return a population; its members are composed where they are named."""
        text = config_path.removeprefix(MIX)
        defaults: list[str | dict[str, str]] = []
        members: dict[str, dict[str, str]] = {}
        for number, part in enumerate(text.split("+"), start=1):
            match = _MEMBER.fullmatch(part.strip())
            if match is None:
                raise InputError(
                    f"model=mix/{text}: '{part}' is not a member. Write model=mix/qwen3:4b@50%+llama3.2@50%, or "
                    "@0-9 for agents, or @attribute:value for a persona."
                )
            members[f"m{number}"] = {key: value for key, value in match.groupdict().items() if value and key != "model"}
            defaults.append({f"/model@members.m{number}.model": match["model"]})
        population = {"_target_": "foundry.models.mixed.MixedModel", "name": f"mix/{text}", "members": members}
        return {"defaults": [*defaults, "_self_"], **population}, "model"


class FolderSource(Source):
    """Serves the files of a folder, and checks each before it is read, since Hydra's own source has no limits."""

    SCHEME = "foundry-folder"

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

    SCHEME = "foundry-sweeps"

    def __init__(self, provider: str, path: str) -> None:
        super().__init__(provider, path)
        self.path = str(paths.sweeps_dir())

    def _place(self, config_path: str) -> Path:
        return Path(self.path) / config_path.removeprefix("sweep").removeprefix("/")
