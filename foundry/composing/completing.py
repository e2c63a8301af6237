"""What a shell may complete: overrides, models, sweeps, folders; from files, but for one short question to Ollama."""

from __future__ import annotations

import contextlib
import http.client
import json
import os
import shlex
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import urlsplit

from foundry import own_code, paths
from foundry.expansion import dotted
from foundry.storing.plain import read_config

PATIENCE_S = 0.2
"""How long the server is given to say its models."""
_SWEEP = "sweep"
_BREAKS = "=:"
"""At these bash ends a word, and takes only what follows the last of them in place of a completion."""
_OUTPUTS = "outputs"


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
        return [found for option in _options(key.lstrip("+"), groups) if (found := start + option).startswith(word)]
    if "." in word:
        return [found for found in _settings(word.partition(".")[0]) if found.startswith(word)]
    named = [f"{group}=" if group != _SWEEP else f"+{_SWEEP}=" for group in groups]
    plain = [*named, *(found for found in _settings("") if "." not in found.partition("=")[0])]
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
    found = {file.relative_to(group).with_suffix("").as_posix() for group, file in files}
    return sorted({*found, *(served() if key == "model" else ())})


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
            found = json.loads(connection.getresponse().read())
        return [str(one["name"]).removesuffix(":latest") for one in found["models"]]
    except (OSError, ValueError, KeyError, TypeError, http.client.HTTPException):
        return []  # a shell that completes has nobody to tell


def folders(word: str) -> list[str]:
    """Return the sweeps' folders that begin so: in outputs/ and in the folder that the word names."""
    found = (file.parent for place in (Path(_OUTPUTS), Path(word).parent) for file in place.glob("*/sweep.yaml"))
    return sorted({str(one) for one in found if str(one).startswith(word)})


def runs(word: str) -> list[str]:
    """Return the runs' folders that begin so."""
    sweeps = [Path(word.partition("/runs")[0])] if "/runs" in word else [Path(one) for one in folders(word)]
    return sorted(str(run) for sweep in sweeps for run in (sweep / "runs").glob("*") if str(run).startswith(word))
