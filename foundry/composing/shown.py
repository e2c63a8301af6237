"""Settings for people: where each comes from, and to what a shell may complete what is typed."""

from __future__ import annotations

import contextlib
import http.client
import json
import os
import re
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from foundry import own_code, paths
from foundry.composing.compose import Composed
from foundry.errors import InputError, not_found
from foundry.expansion import IDENTITY_KEYS, dotted, overridden
from foundry.storing.plain import load_plain, read_config
from foundry.texts import without_secrets

VARIABLES = {
    "OLLAMA_HOST": "servers of Ollama; also in place of those that a resumed sweep began with",
    "OPENAI_BASE_URL": "servers with OpenAI's API; also in place of those that a resumed sweep began with",
    "OPENAI_API_KEY": "key for them, where model.server.api_key_env names no other variable",
    "HF_HOME": "where transformers keeps weights",
    "FOUNDRY_CACHE": "address of the answer cache",
    "FOUNDRY_WORKERS": "worker processes",
    "FOUNDRY_DETERMINISM": "recorded calls that are made again",
    "FOUNDRY_RENDERER": "what draws 3D scenes: auto, software or gpu",
    "FOUNDRY_SCENE_CACHE": "folder for what is computed of scenes",
    "FOUNDRY_WEIGHTS_CACHE": "file for hashes of weights",
    "FOUNDRY_TRUST_TARGETS": "packages whose classes records may name",
    "FOUNDRY_MINE": "folders of your own parts, as --config-dir",
}
"""Variables of the environment that are heeded, and what for."""
_SECRET = re.compile(r"(?:^|[._])(?:api_?key|token|password|secret)$", re.IGNORECASE)
_ADDRESS = re.compile(r"(?:^|[._])(?:host|hosts|base_url)$", re.IGNORECASE)
_USER = re.compile(r"[^\s,/]*@")
_FROM_VARIABLE = re.compile(r"\$\{oc\.env:(\w+)")
MASKED = "***"
_DECIDING = frozenset({*IDENTITY_KEYS, "format", "schema"})
PATIENCE_S = 0.2
"""How long the server is given to say its models."""
_SWEEP = "sweep"
_BREAKS = "=:"
"""At these bash ends a word, and takes only what follows the last of them in place of a completion."""
_OUTPUTS = "outputs"


@dataclass(frozen=True)
class Setting:
    """One setting.

    Attributes:
        setting: its dotted key; a group's is its option.
        value: what holds; secrets are masked.
        origin: `command line`, `environment <variable>`, `user file` or `default`.
    """

    setting: str
    value: Any
    origin: str


def settings_of(composed: Composed) -> Iterator[Setting]:
    """Yield every setting of one run."""
    if len(composed.conditions) > 1 or any(arg.startswith("+sweep=") for arg in composed.asked):
        raise InputError("foundry config shows the settings of one run: leave out -m, +sweep and all values but one.")
    written = dict(dotted(load_plain(composed.multirun, "the configuration")))
    given = overridden(composed.asked) - set(composed.defaults)
    for group, option in composed.choices.items():
        if "/" not in group and "@" not in group:
            yield Setting(group, option, _origin(group, "", given, composed.defaults))
    effective = {**composed.settings, **composed.conditions[0].config, "seed": composed.conditions[0].seeds[0]}
    for key, value in dotted(effective):
        if "schemas" not in key.split(".")[:-1]:  # those of the chosen schema, and long
            raw = str(written.get(key))
            yield Setting(key, _masked(key, value), _origin(key, raw, given, composed.defaults))


def chosen(settings: Iterable[Setting], wanted: Sequence[str]) -> list[Setting]:
    """Return the settings that are wanted, or stand below one that is; all where nothing is."""
    known = list(settings)
    for one in wanted:
        if not any(_is_below(setting.setting, one) for setting in known):
            raise not_found("Setting", one, (setting.setting for setting in known))
    return [one for one in known if not wanted or any(_is_below(one.setting, part) for part in wanted)]


def decides_answers(setting: str) -> bool:
    """Return whether answers depend on a setting; others say where and how a sweep is run."""
    first, *rest = setting.split(".")
    return first in _DECIDING and "server" not in rest


def environment() -> Iterator[Setting]:
    """Yield the variables that are set, secrets masked."""
    for name in VARIABLES:
        if os.environ.get(name):
            yield Setting(name, _masked(name, os.environ[name]), "environment")


def _is_below(key: str, other: str) -> bool:
    return key == other or key.startswith(f"{other}.")


def _origin(key: str, raw: str, said: set[str], defaults: Mapping[str, Any]) -> str:
    if any(key == one or (_is_below(key, one) and "." in one) for one in said):
        return "command line"
    if key in defaults:
        return "user file"
    variable = _FROM_VARIABLE.search(raw)
    return f"environment {variable[1]}" if variable and variable[1] in os.environ else "default"


def _masked(key: str, value: Any) -> Any:
    if value and _SECRET.search(key):
        return MASKED
    if isinstance(value, str):
        return _USER.sub(f"{MASKED}@", value) if _ADDRESS.search(key) else without_secrets(value)
    return [_masked(key, one) for one in value] if isinstance(value, list | tuple) else value


def asked_words() -> tuple[list[str], str]:
    """Return the words before the one that is to be completed, without the command's name, and that one."""
    if "COMP_WORDS" not in os.environ:
        line = os.environ.get("_TYPER_COMPLETE_ARGS", "")
        words = line.split()[1:]
        return (words[:-1], words[-1]) if words and not line.endswith(" ") else (words, "")
    text = os.environ["COMP_WORDS"]
    parts = text.split("\n") if "\n" in text else shlex.split(text)
    number = int(os.environ["COMP_CWORD"])
    *words, last = _rejoined([*parts, ""][1 : number + 1] or [""])
    return words, last


def _rejoined(parts: Sequence[str]) -> list[str]:
    """Return the words as they were typed, which bash has taken apart at `=` and `:`."""
    words: list[str] = []
    for part, before in zip(parts, ["", *parts], strict=False):
        is_break = bool(part) and not part.strip(_BREAKS)
        follows = bool(before) and not before.strip(_BREAKS)
        if words and (is_break or follows):
            words[-1] += part
        else:
            words.append(part)
    return words


def without_broken(completions: str, word: str) -> str:
    """Return completions, one a line, as bash puts them in place of what follows the last break of the word."""
    start = max(word.rfind(sign) for sign in _BREAKS) + 1
    return "".join(f"{line[start:]}\n" for line in completions.splitlines())


def overrides(word: str) -> list[str]:
    """Return what an override that begins so may be: keys with what they are by default, options of groups."""
    key, equals, value = word.partition("=")
    groups = {one.name for folder in _folders() for one in folder.iterdir() if one.is_dir()} | {_SWEEP}
    if equals:
        start = f"{key}={value[: value.rfind(',') + 1]}"
        return [line for option in _options(key.lstrip("+"), groups) if (line := start + option).startswith(word)]
    if "." in word:
        return [line for line in _settings(word.partition(".")[0]) if line.startswith(word)]
    named = [f"{group}=" if group != _SWEEP else f"+{_SWEEP}=" for group in groups]
    plain = [*named, *(line for line in _settings("") if "." not in line.partition("=")[0])]
    fitting = sorted(one for one in plain if one.startswith(word))
    return overrides(fitting[0]) if len(fitting) == 1 and fitting[0].endswith("=") else fitting


def _options(key: str, groups: set[str]) -> list[str]:
    if key == "output.dir":
        return folders("")
    if key == _SWEEP:
        return sorted(file.stem for file in paths.sweeps_dir().glob("*.yaml"))
    if key not in groups:
        return []
    files = ((folder / key, file) for folder in _folders() for file in (folder / key).rglob("*.yaml"))
    names = {file.relative_to(group).with_suffix("").as_posix() for group, file in files}
    return sorted({*names, *(served() if key == "model" else ())})


def _folders() -> list[Path]:
    """Return the shipped folder of configurations, and the user's own that are named on the line."""
    words, _ = asked_words()
    return [paths.conf_dir(), *own_code.folders_named(words)]


def _settings(group: str) -> list[str]:
    """Return the settings of a group's shipped option, or those of no group, with their values."""
    primary = read_config(paths.conf_dir() / "config.yaml")
    shipped = {
        name: option for entry in primary["defaults"] if isinstance(entry, dict) for name, option in entry.items()
    }
    file = paths.conf_dir() / group / f"{shipped.get(group)}.yaml"
    part = {group: read_config(file)} if group and file.is_file() else primary
    return [
        f"{key}={'' if '${' in str(value) else json.dumps(value)}"
        for key, value in dotted(part)
        if not isinstance(value, dict | list) and not key.startswith("hydra") and not key.endswith("_target_")
    ]


def served() -> list[str]:
    """Return the models that the first server of OLLAMA_HOST has; none where it does not say so at once."""
    first = (os.environ.get("OLLAMA_HOST") or "127.0.0.1").split(",")[0].strip()
    address = urlsplit(first if "://" in first else f"http://{first}")
    kind = http.client.HTTPSConnection if address.scheme == "https" else http.client.HTTPConnection
    try:
        host, port = address.hostname or "127.0.0.1", address.port or 11434
        with contextlib.closing(kind(host, port, timeout=PATIENCE_S)) as connection:
            connection.request("GET", "/api/tags")
            listing = json.loads(connection.getresponse().read())
        return [str(one["name"]).removesuffix(":latest") for one in listing["models"]]
    except (OSError, ValueError, KeyError, TypeError, http.client.HTTPException):
        return []  # a shell that completes has nobody to tell


def folders(word: str) -> list[str]:
    """Return the sweeps' folders that begin so: in outputs/ and in the folder that the word names."""
    places = (file.parent for place in (Path(_OUTPUTS), Path(word).parent) for file in place.glob("*/sweep.yaml"))
    return sorted({str(one) for one in places if str(one).startswith(word)})


def runs(word: str) -> list[str]:
    """Return the runs' folders that begin so."""
    sweeps = [Path(word.partition("/runs")[0])] if "/runs" in word else [Path(one) for one in folders(word)]
    return sorted(str(run) for sweep in sweeps for run in (sweep / "runs").glob("*") if str(run).startswith(word))
