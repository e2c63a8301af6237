"""Populations named on the command line: `model=mix/qwen3:4b@50%+llama3.2@50%`."""

import re

from hydra.core.object_type import ObjectType
from hydra.plugins.config_source import ConfigLoadError, ConfigResult, ConfigSource
from omegaconf import OmegaConf

from foundry.errors import InputError

PREFIX = "model/mix/"
TARGET = "foundry.models.mixed.MixedModel"
EXAMPLE = "model=mix/qwen3:4b@50%+llama3.2@50%, or @0-9 for agents, or @attribute:value for a persona"
_MEMBER = re.compile(r"(?P<model>[^@+]+)@(?:(?P<share>[\d.]+%)|(?P<agents>\d+(?:-\d+)?)|(?P<persona>[^@+:]+:[^@+]+))")


class MixSource(ConfigSource):
    """Serves `model=mix/<model>@<rule>+<model>@<rule>...`; each model may be any that `model=` accepts."""

    @staticmethod
    def scheme() -> str:
        """Return the scheme of this source in the search path."""
        return "foundry-mixes"

    def available(self) -> bool:
        """Return whether the source can be used."""
        return True

    def is_group(self, config_path: str) -> bool:
        """Return whether the path is a group of this source."""
        return config_path in ("", "model", PREFIX.rstrip("/"))

    def is_config(self, config_path: str) -> bool:
        """Return whether the path is a population."""
        return config_path.startswith(PREFIX)

    def list(self, config_path: str, results_filter: ObjectType | None) -> list[str]:
        """Return nothing: populations are not known in advance."""
        return []

    def load_config(self, config_path: str) -> ConfigResult:
        """Return a population; its members are composed where they are named."""
        if not self.is_config(config_path):
            raise ConfigLoadError(f"Config not found : {config_path}")
        text = config_path.removesuffix(".yaml").removeprefix(PREFIX)
        defaults: list[str | dict[str, str]] = []
        members: dict[str, dict[str, str]] = {}
        for number, part in enumerate(text.split("+"), start=1):
            match = _MEMBER.fullmatch(part.strip())
            if match is None:
                raise InputError(f"model=mix/{text}: '{part}' is no member. Write {EXAMPLE}.")
            rule = {key: value for key, value in match.groupdict().items() if value and key != "model"}
            members[f"m{number}"] = rule
            defaults.append({f"/model@members.m{number}.model": match["model"]})
        config = OmegaConf.create(
            {"defaults": [*defaults, "_self_"], "_target_": TARGET, "name": f"mix/{text}", "members": members}
        )
        header = {"package": "model"}
        return ConfigResult(config=config, path=f"{self.scheme()}://", provider=self.provider, header=dict(header))
