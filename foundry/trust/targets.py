"""Which classes a recorded configuration may build: it may come from anyone, unlike a command line.

It may build foundry's own parts, classes in the folders that the user names with `--config-dir`, and packages that the
user trusts.
"""

from __future__ import annotations

import importlib
import inspect
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from foundry.errors import InputError
from foundry.expansion import Sweep
from foundry.models.base import Model
from foundry.models.wrappers.base import Wrapper
from foundry.naming import present
from foundry.own_code import own_class
from foundry.prompts.prompt import Prompt
from foundry.running.local import Runner
from foundry.worlds.base import Scenario

VARIABLE = "FOUNDRY_TRUST_TARGETS"
"""Further packages that are trusted, separated by commas."""
ROLES: Mapping[str, type] = {"world": Scenario, "model": Model, "prompt": Prompt, "runner": Runner}
"""What the parts of a configuration build."""
PLACES: Mapping[str, tuple[str, ...]] = {
    "world": ("foundry.worlds",),
    "model": ("foundry.models", "foundry.running.replayed"),
    "prompt": ("foundry.prompts",),
    "fork": ("foundry.prompts",),
    "runner": ("foundry.running.local", "foundry.running.dask"),
}
"""Where the classes are that each part of a configuration may name, at any depth."""
PACKAGES = tuple(dict.fromkeys(package for packages in PLACES.values() for package in packages))
SCRIPTED = "foundry.models.scripted"
"""Policies and their parts, such as faults: they take numbers and other policies, and touch nothing."""
HYDRAS_OWN = ("_partial_", "_args_", "_recursive_", "_convert_")


def check_sweep_targets(sweep: Sweep, settings: Mapping[str, Any], trusted: Sequence[str] = ()) -> None:
    """Refuse a recorded sweep that would build anything but foundry's own parts and those in the user's own folders.

    Args:
        sweep: as recorded.
        settings: as recorded; of them the runner is built.
        trusted: further packages whose classes may be built.

    Raises:
        InputError: it would.
    """
    for number, condition in enumerate(sweep.conditions, start=1):
        check_targets(condition.config, trusted, f"condition {number}")
    check_targets({"runner": settings.get("runner", {})}, trusted, "the settings")


def check_targets(config: Mapping[str, Any], trusted: Sequence[str], where: str) -> None:
    """Refuse a recorded configuration that would build anything but foundry's own parts and the user's own.

    The user's own folders are those that the user names. No record can name one.

    Raises:
        InputError: it would.
    """
    trusted = (*trusted, *filter(None, os.environ.get(VARIABLE, "").split(",")))
    for role, kind in ROLES.items():
        part = config.get(role)
        if isinstance(part, Mapping) and "_target_" in part:
            _check_role(part["_target_"], kind, trusted, f"{where}, {role}")
    for path, key, value in _entries(config, ()):
        if key in HYDRAS_OWN and not trusted:
            raise InputError(f"{where}: '{'.'.join(path)}' is refused: a recorded configuration may not use {key}.")
        if key == "_target_":
            _check_target(value, PLACES.get(path[0], ()), trusted, f"{where}, {'.'.join(path[:-1])}")


def own_packages(sweep: Sweep) -> list[str]:
    """Return where the classes are, beside foundry's own, that a sweep names which is trusted already."""
    named = (str(value) for one in sweep.conditions for _, key, value in _entries(one.config, ()) if key == "_target_")
    packages = dict.fromkeys(target.rpartition(".")[0] for target in named)
    return [package for package in packages if package and not _is_within(package, ("foundry",))]


def _entries(value: Any, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], str, Any]]:
    """Yield every key at any depth with its path and its value."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield (*path, str(key)), str(key), inner
            yield from _entries(inner, (*path, str(key)))
    elif isinstance(value, list | tuple):
        for number, inner in enumerate(value):
            yield from _entries(inner, (*path, str(number)))


def _check_role(target: Any, kind: type, trusted: Sequence[str], where: str) -> None:
    if _is_trusted(target, trusted):
        return
    if not issubclass(_users_class(target) or _own_class(target, where), kind):
        raise _refusal(target, where, f"it is no {kind.__name__}")


def _check_target(target: Any, packages: Sequence[str], trusted: Sequence[str], where: str) -> None:
    if _is_trusted(target, trusted) or _users_class(target):
        return
    found = _own_class(target, where)
    if not _is_within(found.__module__, packages):
        raise _refusal(target, where, "it has no place there")
    is_of_models = _is_within(found.__module__, ("foundry.models",))
    if is_of_models and not issubclass(found, Model) and not _is_within(found.__module__, (SCRIPTED,)):
        raise _refusal(target, where, "it is no model")
    if issubclass(found, Wrapper):
        raise _refusal(target, where, "it wraps other models, which foundry does by itself")


def _is_trusted(target: Any, trusted: Iterable[str]) -> bool:
    return isinstance(target, str) and any(target.startswith(f"{package}.") for package in trusted)


def _users_class(target: Any) -> type | None:
    return own_class(target) if isinstance(target, str) else None


def _own_class(target: Any, where: str) -> type:
    """Return the class of foundry that a target names; only modules of foundry are imported for that."""
    now = present(target)
    if not isinstance(now, str) or not _is_within(now, PACKAGES):
        raise _refusal(target, where, "it is not one of foundry's own")
    module, _, name = now.rpartition(".")
    try:
        found = getattr(importlib.import_module(module), name, None)
    except ImportError as error:
        raise _refusal(target, where, "there is no such module") from error
    if not inspect.isclass(found):
        raise _refusal(target, where, "it is no class of foundry")
    return found


def _is_within(name: str, packages: Iterable[str]) -> bool:
    return any(name == package or name.startswith(f"{package}.") for package in packages)


def _refusal(target: Any, where: str, why: str) -> InputError:
    package = str(target).rpartition(".")[0] or target
    return InputError(
        f"{where}: the recorded target '{target}' is refused: {why}. If it is code of your own, name its folder with "
        f"--config-dir. If you trust where the record comes from, allow it with --trust-targets {package}."
    )
