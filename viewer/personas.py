"""Finds an agent's persona in its own prompt, the one place of the records that states it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from foundry.records import Call

_READ_CALL = msgspec.json.Decoder(Call).decode


def stated_persona(personas: Mapping[str, Mapping[Any, float]], calls: Sequence[bytes]) -> dict[str, str]:
    """Return the first of each attribute's values that a prompt names; what no prompt names is left out.

    Args:
        personas: the world's setting, attribute to values and weights.
        calls: log lines of the agent's first step. An agent's prompt speaks of itself before it speaks of others.
    """
    if not calls:
        return {}
    prompt = "\n".join(str(message.get("content", "")) for message in _READ_CALL(calls[0]).messages)
    found = {name: _first_named(prompt, [str(value) for value in values]) for name, values in personas.items()}
    return {name: value for name, value in found.items() if value is not None}


def _first_named(text: str, values: Sequence[str]) -> str | None:
    pattern = "|".join(rf"(?<!\w){re.escape(value)}(?!\w)" for value in sorted(values, key=len, reverse=True))
    match = re.search(pattern, text) if values else None
    return match[0] if match else None
