"""Limits the classes that a record of unknown origin can use, and the servers that it can contact.

A record of unknown origin can name classes that foundry then loads. foundry loads only its own classes, classes in
folders that the user names with `--config-dir`, and classes of trusted packages. A record of unknown
origin can make foundry contact only this machine and servers that the user has named.
"""

import importlib
import inspect
import ipaddress
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any
from urllib.parse import urlsplit

from foundry import own_code, paths
from foundry.errors import InputError
from foundry.expansion import Sweep, dotted, models_in
from foundry.models.base import Model
from foundry.models.wrappers.wrapper import Wrapper
from foundry.naming import POLICY_MODULES, present
from foundry.prompts.prompt import Prompt
from foundry.running.local import Runner
from foundry.storing.plain import load_plain
from foundry.texts import without_secrets
from foundry.worlds.base import Scenario

VARIABLE = "FOUNDRY_TRUST_TARGETS"
"""The environment variable that names further trusted packages, separated by commas."""
ROLES: Mapping[str, tuple[type, tuple[str, ...]]] = {
    "world": (Scenario, ("foundry.worlds",)),
    "model": (Model, ("foundry.models", *POLICY_MODULES.values(), "foundry.running.replayed")),
    "prompt": (Prompt, ("foundry.prompts",)),
    "fork": (object, ("foundry.prompts",)),
    "runner": (Runner, ("foundry.running.local", "foundry.running.dask")),
}
"""For each part of a configuration: the base class of its class, and the modules from which its classes may come."""
PACKAGES = tuple(package for _, packages in ROLES.values() for package in packages)
SCRIPTED = "foundry.models.scripted"
"""The package with the scripted model that gives faulty replies on purpose; all its classes are harmless."""
HYDRAS_OWN = ("_partial_", "_args_", "_recursive_", "_convert_")
HOSTED = "https://api.openai.com/v1"
"""The server that gets `OPENAI_API_KEY` if the user names no other server."""
VARIABLES = {"address": "DASK_SCHEDULER_ADDRESS", "path": "FOUNDRY_CACHE"}
"""The settings that contain an address, each with the environment variable that can name the same address."""


def check_sweep_targets(sweep: Sweep, settings: Mapping[str, Any], trusted: Sequence[str] = ()) -> None:
    """Raise an error if a recorded sweep names a class that a record of unknown origin must not use."""
    for number, condition in enumerate(sweep.conditions, start=1):
        check_targets(condition.config, trusted, f"condition {number}")
    check_targets({"runner": settings.get("runner", {})}, trusted, "the settings")


def check_targets(config: Mapping[str, Any], trusted: Sequence[str], where: str) -> None:
    """Raise an error if a recorded configuration names a forbidden class; the error begins with `where`."""
    trusted = (*trusted, *filter(None, os.environ.get(VARIABLE, "").split(",")))
    for path, value in _entries(config, ()):
        if path[-1] in HYDRAS_OWN and not trusted:
            raise InputError(
                f"{where}: '{'.'.join(path)}' is refused: a recorded configuration may not use {path[-1]}."
            )
        if path[-1] != "_target_" or (
            isinstance(value, str) and value.startswith(tuple(f"{package}." for package in trusted))
        ):
            continue
        kind, packages = ROLES.get(path[0], (object, ()))
        if why := _why_not(value, kind if len(path) == 2 else object, packages):
            raise InputError(
                f"{where}, {'.'.join(path[:-1])}: the recorded target '{value}' is refused: {why}. For your own "
                "code, name its folder with --config-dir. If you trust the origin of the record, allow it with "
                f"--trust-targets {str(value).rpartition('.')[0] or value}."
            )


def own_packages(sweep: Sweep) -> list[str]:
    """Return the modules of the classes that a trusted sweep names, except those of foundry."""
    entries = (entry for condition in sweep.conditions for entry in _entries(condition.config, ()))
    packages = dict.fromkeys(str(value).rpartition(".")[0] for path, value in entries if path[-1] == "_target_")
    return [package for package in packages if package and not _is_within(package, ("foundry",))]


def _entries(value: Any, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield (*path, str(key)), inner
            yield from _entries(inner, (*path, str(key)))
    elif isinstance(value, list | tuple):
        for number, inner in enumerate(value):
            yield from _entries(inner, (*path, str(number)))


def _why_not(target: Any, kind: type, packages: Sequence[str]) -> str:
    """Return the reason why foundry refuses to build a recorded `_target_`; "" if foundry may build it."""
    own = own_code.own_class(target) if isinstance(target, str) else None
    now = present(target)
    if own is None and not _is_within(now, PACKAGES):
        return "it is not one of foundry's own"
    module, _, name = str(now).rpartition(".")
    try:
        part = own or getattr(importlib.import_module(module), name, None)  # only modules of foundry are imported
    except ImportError:
        return "the module does not exist"
    if not inspect.isclass(part):
        return "it is not a class of foundry"
    if not issubclass(part, kind):
        return f"it is not a {kind.__name__}"
    if own is not None:
        return ""
    if not _is_within(part.__module__, packages):
        return "it is not allowed there"
    if _is_within(part.__module__, ("foundry.models",)):
        if not issubclass(part, Model) and not _is_within(part.__module__, (SCRIPTED,)):
            return "it is not a model"
        if issubclass(part, Wrapper):
            return "it wraps other models, which only foundry itself may do"
    return ""


def _is_within(name: Any, packages: Iterable[str]) -> bool:
    return isinstance(name, str) and any(name == package or name.startswith(f"{package}.") for package in packages)


def check_models(
    models: Iterable[Mapping[str, Any]],
    *,
    typed: Sequence[str] = (),
    recorded: Iterable[Mapping[str, Any]] | None = None,
) -> None:
    """Raise an error if foundry would send a key from the environment to a server that only a record names.

    Args:
        models: configurations of the models that will be built.
        typed: overrides that the user typed; a server in them is named by the user.
        recorded: configurations of all models in the record that the overrides change; None if `models` come from the
            record themselves.
    """
    known = {HOSTED, *_urls(os.environ.get("OPENAI_BASE_URL", "")), *_configured()}
    own = [override for override in typed if override.partition("=")[0].endswith("base_url")]
    reached = _keyed(models)
    for variable, url in sorted(reached if recorded is None else reached & _keyed(recorded)):
        if url not in known and not _is_local(url) and not any(url in override for override in own):
            raise InputError(
                f"The record would send the key in {variable} to '{without_secrets(url)}'. Set OPENAI_BASE_URL to "
                "your own server, or allow the server in the record with --trust-servers."
            )


def check_settings(settings: Mapping[str, Any]) -> None:
    """Raise an error if settings use a cluster, a store or a database that only a record names.

    It could run code or receive passwords.
    """
    for part in ("runner", "cache"):
        for key, value in settings.get(part, {}).items():
            variable = VARIABLES.get(key)
            if not isinstance(value, str) or "://" not in value or _is_local(value):
                continue
            if variable is None or os.environ.get(variable) != value:
                way_on = f"set {variable} to it, or " if variable else ""
                raise InputError(
                    f"The record would connect to '{without_secrets(value)}' ({part}.{key}). If this address is yours, "
                    f"{way_on}allow it with --trust-servers."
                )


def _configured() -> Iterator[str]:
    folders = own_code.own_folders()
    for file in (paths.user_config_file(), *(file for folder in folders for file in folder.rglob("*.yaml"))):
        if file.is_file():
            content = load_plain(file.read_text(encoding="utf-8"), file)
            for key, value in dotted(content) if isinstance(content, Mapping) else ():
                if key.rpartition(".")[2] == "base_url" and value:
                    yield from _urls(value)


def _keyed(models: Iterable[Mapping[str, Any]]) -> set[tuple[str, str]]:
    """Return every server that would get a key: the environment variable of the key, and the server's address."""
    servers = [part.get("server") or {} for model in models for part in models_in(model)]
    return {
        (variable, url)
        for server in servers
        if isinstance(variable := server.get("api_key_env"), str) and os.environ.get(variable)
        for url in _urls(server.get("base_url", HOSTED))
    }


def _urls(base_url: str | Sequence[str]) -> list[str]:
    parts = base_url.split(",") if isinstance(base_url, str) else [str(url) for url in base_url]
    return [part.strip() for part in parts if part.strip()]


def _is_local(url: str) -> bool:
    """Return whether an address belongs to this machine, or names a file."""
    try:
        parts = urlsplit(url if "://" in url else f"//{url}")
        if parts.query or parts.hostname is None:
            return parts.scheme == "file"
        return parts.hostname == "localhost" or ipaddress.ip_address(parts.hostname).is_loopback
    except ValueError:
        return False
