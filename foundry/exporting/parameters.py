"""How replies were sampled, in the words that other tools share."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_WORDS = {
    "temperature": "temperature",
    "top_p": "top_p",
    "top_k": "top_k",
    "frequency_penalty": "frequency_penalty",
    "presence_penalty": "presence_penalty",
    "stop": "stop",
    "max_tokens": "max_tokens",
    "max_completion_tokens": "max_tokens",
    "num_predict": "max_tokens",
}


def sampling(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return those parameters of a call that other tools know, by their common names.

    Args:
        parameters: `Call.parameters`; Ollama has them below `options`.
    """
    given = {**parameters, **parameters.get("options", {})}
    found = {_WORDS[name]: value for name, value in given.items() if name in _WORDS and value is not None}
    if found.get("max_tokens", 1) < 1:  # Ollama's words for no limit
        del found["max_tokens"]
    return found
