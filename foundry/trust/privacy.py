"""Removes paths, user names and secrets from bundles and exports."""

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from foundry.errors import InputError
from foundry.records import Call

LOCAL_URL = "http://127.0.0.1"
"""The address that replaces every server's address, since addresses do not affect answers."""
_HOMES = re.compile(r"(?:/home|/Users)/[^/\s'\":,]+|[A-Za-z]:(?:\\{1,2}|/)Users(?:\\{1,2}|/)[^\\/\s'\":,]+")
_SECRET_NAME = re.compile(r"KEY|TOKEN|SECRET|PASSWORD|PASSWD|CREDENTIAL", re.IGNORECASE)
_SHORTEST_SECRET = 8
_MACHINE_KEYS = ("output", "cache", "hydra")
"""Settings that concern the machine, and not the sweep."""


class Scrubber:
    """Removes the paths, the user names and the servers of this machine from texts."""

    def __init__(self) -> None:
        homes = {str(Path.home()), str(Path.home().resolve())} - {"/", ""}
        self._homes = sorted(homes, key=len, reverse=True)
        self._here = f"{Path.cwd()}{os.sep}"
        self._secrets = {
            name: value
            for name, value in os.environ.items()
            if _SECRET_NAME.search(name) and len(value) >= _SHORTEST_SECRET
        }

    def text(self, text: str) -> str:
        """Return a text without the working directory, and with `~` for home folders."""
        text = text.replace(self._here, "") if len(self._here) > 1 else text
        for home in self._homes:
            text = re.sub(rf"{re.escape(home)}(?=[/\\]|\b)", "~", text)
        return _HOMES.sub("~", text)

    def value(self, value: Any) -> Any:
        """Return a copy of a value (of dicts, lists and texts) in which `text` has scrubbed each text."""
        if isinstance(value, str):
            return self.text(value)
        if isinstance(value, Mapping):
            return {key: self.value(inner) for key, inner in value.items()}
        return [self.value(inner) for inner in value] if isinstance(value, list | tuple) else value

    def config(self, config: Mapping[str, Any]) -> dict[str, Any]:
        """Return a configuration without paths of this machine and addresses of servers."""
        scrubbed: dict[str, Any] = self.value(_without_servers(config))
        return scrubbed

    def call(self, call: Call) -> Call:
        """Return a logged call without the names of servers; its prompt and reply do not change."""
        host = call.host or "\0"
        attempts = tuple(
            replace(attempt, error=self.text(attempt.error).replace(host, "the server")) for attempt in call.attempts
        )
        served = None if call.served_model is None else self.text(call.served_model)
        remote = None if call.remote is None else self.text(call.remote)
        return replace(call, host=None, attempts=attempts, served_model=served, remote=remote)

    def asked(self, overrides: tuple[str, ...]) -> tuple[str, ...]:
        """Return the overrides of a command line, except those that only concern this machine."""
        return tuple(self.text(override) for override in overrides if not _is_of_machine(override))

    def check(self, name: str, content: bytes) -> None:
        """Raise an error if content still contains the path of a home folder or the value of a secret variable."""
        text = content.decode("utf-8", "replace")
        for variable, value in self._secrets.items():
            if value in text:
                raise InputError(f"'{name}' holds the value of {variable}: nothing was written.")
        if any(f"{home}{os.sep}" in text for home in self._homes):
            raise InputError(f"'{name}' holds the path of a home folder, in a prompt or a reply: nothing was written.")


def _is_of_machine(override: str) -> bool:
    key = override.lstrip("+~").partition("=")[0]
    return key.split(".")[0] in _MACHINE_KEYS or ".server." in f"{key}." or override.startswith("--config")


def _without_servers(value: Any) -> Any:
    if not isinstance(value, Mapping):
        return value
    return {key: _anonymous(inner) if key == "server" else _without_servers(inner) for key, inner in value.items()}


def _anonymous(server: Any) -> Any:
    if not isinstance(server, Mapping):
        return server
    return {key: LOCAL_URL if key in ("hosts", "base_url") else value for key, value in server.items()}
