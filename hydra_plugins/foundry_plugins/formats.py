"""Formats drawn from a space named on the command line: `format=spread/3`."""

import re

from hydra.core.object_type import ObjectType
from hydra.plugins.config_source import ConfigLoadError, ConfigResult, ConfigSource
from omegaconf import OmegaConf

_DRAWN = re.compile(r"format/(?P<space>[^/]+)/(?P<draw>\d{1,9})")


class FormatSource(ConfigSource):
    """Serves `format=<space>/<number>` as the space's file with the number of the draw, below the prompt."""

    @staticmethod
    def scheme() -> str:
        """Return the scheme of this source in the search path."""
        return "foundry-formats"

    def available(self) -> bool:
        """Return whether the source can be used."""
        return True

    def is_group(self, config_path: str) -> bool:
        """Return whether the path is a group of this source."""
        return config_path in ("", "format")

    def is_config(self, config_path: str) -> bool:
        """Return whether the path is a drawn format."""
        return _DRAWN.fullmatch(config_path.removesuffix(".yaml")) is not None

    def list(self, config_path: str, results_filter: ObjectType | None) -> list[str]:
        """Return nothing: draws are not known in advance."""
        return []

    def load_config(self, config_path: str) -> ConfigResult:
        """Return the space with the number of the draw."""
        found = _DRAWN.fullmatch(config_path.removesuffix(".yaml"))
        if found is None:
            raise ConfigLoadError(f"Config not found : {config_path}")
        defaults = [f"/format/{found['space']}@_here_", "_self_"]
        config = OmegaConf.create({"defaults": defaults, "draw": int(found["draw"])})
        header = {"package": "prompt.format"}
        return ConfigResult(config=config, path=f"{self.scheme()}://", provider=self.provider, header=dict(header))
