"""What edits of personas share: which attributes there are, and one persona with something of another."""

from __future__ import annotations

from collections.abc import Mapping

from foundry.worlds.base import Scenario


def attributes(scenario: Scenario) -> tuple[str, ...]:
    """Return the attributes of a world's personas, in their order."""
    return tuple(dict.fromkeys(name for persona in scenario.personas(0) for name in persona))


def with_part(own: Mapping[str, str], other: Mapping[str, str], part: str | None) -> dict[str, str]:
    """Return a persona with one attribute of another one; where none is named, the other one."""
    if part is None:
        return dict(other)
    return {name: other.get(name, value) if name == part else value for name, value in own.items()}
