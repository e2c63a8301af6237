"""Lists the settings of a run, and where each value comes from."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from foundry.composing.compose import Composed
from foundry.errors import InputError, not_found
from foundry.expansion import IDENTITY_KEYS, dotted, overridden
from foundry.storing.plain import load_plain
from foundry.texts import without_secrets

VARIABLES = {
    "OLLAMA_HOST": "addresses of Ollama servers; a resumed sweep uses these and not its first ones",
    "OPENAI_BASE_URL": "addresses of servers with OpenAI's API; a resumed sweep uses these and not its first ones",
    "OPENAI_API_KEY": "key for servers with OpenAI's API, if model.server.api_key_env names no other variable",
    "HF_HOME": "folder in which transformers keeps weights",
    "FOUNDRY_CACHE": "address of the answer cache",
    "FOUNDRY_WORKERS": "number of worker processes",
    "FOUNDRY_CANARY": "whether canary calls check the weights of each model",
    "FOUNDRY_DETERMINISM": "number of recorded calls that are repeated at the end of a sweep",
    "FOUNDRY_RENDERER": "renderer of 3D scenes: auto, software or gpu",
    "FOUNDRY_SCENE_CACHE": "folder of prepared scenes",
    "FOUNDRY_WEIGHTS_CACHE": "file with the hashes of local weights",
    "FOUNDRY_TRUST_TARGETS": "packages whose classes records may name",
    "FOUNDRY_MINE": "folders with your own parts, like --config-dir",
}
"""Environment variables that foundry reads, each with its purpose."""
_SECRET = re.compile(r"(?:^|[._])(?:api_?key|token|password|secret)$", re.IGNORECASE)
_ADDRESS = re.compile(r"(?:^|[._])(?:host|hosts|base_url)$", re.IGNORECASE)
_USER = re.compile(r"[^\s,/]*@")
_FROM_VARIABLE = re.compile(r"\$\{oc\.env:(\w+)")
MASKED = "***"
_DECIDING = frozenset({*IDENTITY_KEYS, "format", "schema"})


@dataclass(frozen=True)
class Setting:
    """One setting.

    Attributes:
        setting: the dotted key, or the name of a group.
        value: the value that applies, with secrets masked.
        origin: `command line`, `environment <variable>`, `user file` or `default`.
    """

    setting: str
    value: Any
    origin: str


def settings_of(composed: Composed) -> Iterator[Setting]:
    """Yield every setting of one run."""
    if len(composed.conditions) > 1 or any(arg.startswith("+sweep=") for arg in composed.asked):
        raise InputError("foundry config shows the settings of one run. Leave out -m, +sweep and lists of values.")
    written = dict(dotted(load_plain(composed.multirun, "the configuration")))
    given = overridden(composed.asked[len(composed.chosen) :])
    defaults = {**composed.defaults.choices, **composed.defaults.settings}
    for group, option in composed.choices.items():
        if "/" not in group and "@" not in group:
            yield Setting(group, option, _origin(group, option, "", given, defaults))
    effective = {**composed.settings, **composed.conditions[0].config, "seed": composed.conditions[0].seeds[0]}
    for key, value in dotted(effective):
        if "schemas" not in key.split(".")[:-1]:  # schemas are long, and follow from the chosen schema
            raw = str(written.get(key))
            yield Setting(key, _masked(key, value), _origin(key, value, raw, given, defaults))


def chosen(settings: Iterable[Setting], wanted: Sequence[str]) -> list[Setting]:
    """Return the named settings and all settings below them; all settings if none is named."""
    known = list(settings)
    for wish in wanted:
        if not any(_is_below(setting.setting, wish) for setting in known):
            raise not_found("Setting", wish, (setting.setting for setting in known))
    return [setting for setting in known if not wanted or any(_is_below(setting.setting, part) for part in wanted)]


def decides_answers(setting: str) -> bool:
    """Return whether answers depend on a setting; other settings only say where and how a sweep runs."""
    first, *rest = setting.split(".")
    return first in _DECIDING and "server" not in rest


def environment() -> Iterator[Setting]:
    """Yield the environment variables that are set, with secrets masked."""
    for name in VARIABLES:
        if os.environ.get(name):
            yield Setting(name, _masked(name, os.environ[name]), "environment")


def _is_below(key: str, other: str) -> bool:
    return key == other or key.startswith(f"{other}.")


def _origin(key: str, value: Any, raw: str, said: set[str], defaults: Mapping[str, Any]) -> str:
    if any(key == named or (_is_below(key, named) and "." in named) for named in said):
        return "command line"
    if key in defaults and defaults[key] == value:
        return "user file"
    variable = _FROM_VARIABLE.search(raw)
    return f"environment {variable[1]}" if variable and variable[1] in os.environ else "default"


def _masked(key: str, value: Any) -> Any:
    if value and _SECRET.search(key):
        return MASKED
    if isinstance(value, str):
        return _USER.sub(f"{MASKED}@", value) if _ADDRESS.search(key) else without_secrets(value)
    return [_masked(key, item) for item in value] if isinstance(value, list | tuple) else value
