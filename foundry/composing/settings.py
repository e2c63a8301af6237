"""Checks the parts of a composed condition, and the settings that say where and how it runs."""

from collections.abc import Mapping, Sequence
from typing import Any

from foundry.errors import InputError
from foundry.storing.determinism import AUTO, SETTING

USED_OF_HYDRA = ("hydra/launcher", "hydra.launcher", "hydra.mode", "hydra.searchpath", "hydra.sweeper.params")
"""Settings of Hydra that a command line may contain."""
BASELINES = "baselines"
"""Value of the setting `analyze` with which foundry runs the scripted baselines before the analysis."""
UNTIL = "until"
"""Name of the setting that ends a preregistered sweep at the first look that answers its question."""
ANSWERED = "answered"
PARTS = ("world", "model", "prompt")
"""The parts of a condition. The configuration of each part has a name and a class to build."""


def checked_settings(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Check composed settings, and convert paths that are numbers, as in `output.dir=7`, to texts."""
    cache = settings.get("cache")  # cache=postgresql://... is short for cache.path=...
    folder = _entry(settings, "output", "dir")
    if not isinstance(analyze := settings.get("analyze"), bool) and analyze != BASELINES:
        raise InputError(f"analyze must be true, false or {BASELINES}; got {analyze}.")
    if (until := settings.get(UNTIL)) not in (None, ANSWERED):
        raise InputError(f"{UNTIL} must be null or {ANSWERED}; got {until}.")
    _check_part("runner", settings.get("runner"))
    return {
        **settings,
        "cache": {"path": _path("cache.path", cache if isinstance(cache, str) else _entry(settings, "cache", "path"))},
        "output": {"dir": None if folder is None else _path("output.dir", folder)},
        "record": {"frames": _frames(_entry(settings, "record", "frames"))},
        SETTING: _repeated(settings.get(SETTING, 0)),
    }


def check_parts(config: Mapping[str, Any]) -> None:
    """Raise an error if the world, model or prompt of a condition is missing or has no class or name."""
    for role in PARTS:
        _check_part(role, config.get(role))
        if not isinstance(config[role].get("name"), str):
            raise InputError(f"The chosen {role} has no name. Its file needs a line 'name: ...' with a text.")
    names = config.get("baselines")
    if names is not None and not (isinstance(names, list) and all(isinstance(name, str) for name in names)):
        raise InputError(f"baselines must be a list of policies; got {names}. Write baselines: [scripted/random, ...].")


def _check_part(role: str, part: object) -> None:
    if part is None:
        raise InputError(f"No {role} is chosen. Name one with {role}=...")
    if not isinstance(part, Mapping) or not isinstance(part.get("_target_"), str):
        raise InputError(
            f"The file of the chosen {role} must contain lines 'key: value'. One of them must be '_target_: ...' with "
            "the class to build."
        )


def _entry(settings: Mapping[str, Any], key: str, name: str) -> Any:
    part = settings.get(key)
    if not isinstance(part, Mapping) or name not in part:
        raise InputError(f"{key}={part} does not set '{name}'. Use {key}.{name}=... instead.")
    return part[name]


def _path(key: str, value: object) -> str:
    if isinstance(value, str) or type(value) is int:
        return str(value)
    raise InputError(f"{key} must be a path of a file; got {value}.")


def _repeated(value: object) -> int | str:
    if value == AUTO or (isinstance(value, int) and not isinstance(value, bool) and value >= 0):
        return value
    raise InputError(f"{SETTING} must be {AUTO} or a whole number of calls, 0 for none; got {value}.")


def _frames(value: object) -> bool | int:
    if isinstance(value, int) and value >= 0:
        return value
    raise InputError(f"record.frames must be true, false or a number of steps; got {value}.")


def check_settings_of_hydra(argv: Sequence[str]) -> None:
    """Reject settings of Hydra that would have no effect, since foundry uses Hydra only to compose."""
    for arg in argv:
        key = arg.lstrip("+~").partition("=")[0]
        if key.startswith(("hydra.", "hydra/")) and not f"{key}.".startswith(
            tuple(f"{name}." for name in USED_OF_HYDRA)
        ):
            raise InputError(
                f"'{key}' is a setting of Hydra that foundry does not use. It uses: {', '.join(USED_OF_HYDRA)}. "
                "Write a sweep as -m key=a,b and its folder as output.dir=DIR."
            )
