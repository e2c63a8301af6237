"""What a recorded sweep would connect to when it goes on; it may come from anyone, unlike a command line."""

from __future__ import annotations

import ipaddress
import itertools
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any
from urllib.parse import urlsplit

from foundry import own_code, paths
from foundry.errors import InputError
from foundry.expansion import dotted, models_in
from foundry.storing.plain_yaml import load_plain
from foundry.texts import without_secrets

HOSTED = "https://api.openai.com/v1"
"""Where `OPENAI_API_KEY` belongs when no server is named."""
VARIABLES = {"address": "DASK_SCHEDULER_ADDRESS", "path": "FOUNDRY_CACHE"}
"""Settings that hold addresses, with the variable that may name the same address."""


def check_models(
    models: Iterable[Mapping[str, Any]],
    *,
    typed: Sequence[str] = (),
    recorded: Iterable[Mapping[str, Any]] | None = None,
) -> None:
    """Refuse to send a key of the environment to a server that only a record names.

    Args:
        models: configurations of models that would be built.
        typed: overrides of the user; a base URL in there is the user's own.
        recorded: configurations of every model of the records that they were composed over. None where they are the
            recorded ones.

    Raises:
        InputError: a key would be sent.
    """
    known = {HOSTED, *_urls(os.environ.get("OPENAI_BASE_URL", "")), *_configured()}
    own = [override for override in typed if override.partition("=")[0].endswith("base_url")]
    reached = _all_keyed(models)
    for variable, url in sorted(reached if recorded is None else reached & _all_keyed(recorded)):
        if url not in known and not _is_local(url) and not any(url in override for override in own):
            raise InputError(
                f"The record would have the key in {variable} sent to '{without_secrets(url)}': set OPENAI_BASE_URL to "
                "the server that you want, or allow this one with --trust-servers."
            )


def check_settings(settings: Mapping[str, Any]) -> None:
    """Refuse a cluster, a store or a database that only a record names: what they send is run, or gets passwords.

    Raises:
        InputError: the record names one on another machine.
    """
    for part in ("runner", "cache"):
        for key, value in settings.get(part, {}).items():
            variable = VARIABLES.get(key)
            if not isinstance(value, str) or "://" not in value or _is_local(value):
                continue
            if variable is None or os.environ.get(variable) != value:
                way_on = f"set {variable} to the same, or " if variable else ""
                raise InputError(
                    f"The record would connect to '{without_secrets(value)}' ({part}.{key}): if that is yours, "
                    f"{way_on}allow it with --trust-servers."
                )


def _configured() -> Iterator[str]:
    """Yield the base URLs in the user's own defaults and folders of configurations."""
    folders = own_code.own_folders()
    for file in (paths.user_config_file(), *(file for folder in folders for file in folder.rglob("*.yaml"))):
        if file.is_file():
            content = load_plain(file.read_text(encoding="utf-8"), file)
            for key, value in dotted(content) if isinstance(content, Mapping) else ():
                if key.rpartition(".")[2] == "base_url" and value:
                    yield from _urls(value)


def _all_keyed(models: Iterable[Mapping[str, Any]]) -> set[tuple[str, str]]:
    return set(itertools.chain.from_iterable(map(_keyed, models)))


def _keyed(model: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the variable and the address of every server that would get a key, at any depth."""
    for one in models_in(model):
        server = one.get("server") or {}
        variable = server.get("api_key_env")
        if isinstance(variable, str) and os.environ.get(variable):
            for url in _urls(server.get("base_url", HOSTED)):
                yield variable, url


def _urls(base_url: str | Sequence[str]) -> list[str]:
    parts = base_url.split(",") if isinstance(base_url, str) else [str(one) for one in base_url]
    return [part.strip() for part in parts if part.strip()]


def _is_local(url: str) -> bool:
    """Return whether an address is this machine's, or a file's."""
    try:
        parts = urlsplit(url if "://" in url else f"//{url}")
        if parts.query or parts.hostname is None:
            return parts.scheme == "file"
        return parts.hostname == "localhost" or ipaddress.ip_address(parts.hostname).is_loopback
    except ValueError:
        return False
