"""Reads the API key for servers with OpenAI's API, and the servers' lists of models."""

import hashlib
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from foundry.errors import InputError, not_found
from foundry.models.base import Loaded, ModelInfo
from foundry.models.http.transport import Origin, decoded, length_in

VARIABLE = re.compile(r"(?:[A-Z][A-Z0-9_]*_)?API_KEY")
"""Pattern of the environment variables from which an API key may be read. A stranger may have written the settings of a
sweep, and these must not name a variable that holds another secret.
"""
SHORTEST = 8
"""Minimum length of a real API key. A shorter key is a placeholder such as `EMPTY`, which is not removed from
errors.
"""
SHORTEST_IN_REPLIES = 12
"""Minimum length of a key that is removed from replies. A shorter key may equal a word that the model wrote."""
REDACTED = b"[key]"
LASTING = ("id", "owned_by", "root", "parent", "max_model_len", "quantization", "meta", "hugging_face_id", "version")
"""Fields in a server's list of models that identify a model. The other fields may change although the model is the
same, for example with the price or a restart.
"""
FLAGS = ("max_model_len", "n_ctx")
"""Fields in a server's list of models that depend on the flags with which the server was started."""
LENGTHS = ("max_model_len", "context_length", "context_window", "max_context_length")


@dataclass(frozen=True)
class Secret:
    """The key for a server; empty if there is none."""

    key: str = field(repr=False)

    @classmethod
    def from_environment(cls, variable: str | None) -> "Secret":
        """Read the key from the environment variable; it is empty if the variable is not set."""
        if variable is None:
            return cls("")
        if not VARIABLE.fullmatch(variable):
            raise InputError(
                "model.server.api_key_env must be the name of an environment variable that ends with API_KEY. Put the "
                "key into such a variable, for example OPENAI_API_KEY, and use its name."
            )
        key = os.environ.get(variable, "").strip()
        if not key.isascii() or not key.isprintable() or " " in key:
            raise InputError(
                f"The value of {variable} is not a key: it contains spaces, or characters that HTTP does not allow."
            )
        return cls(key)

    @property
    def headers(self) -> dict[str, str]:
        """The HTTP headers that send the key."""
        return {"authorization": f"Bearer {self.key}"} if self.key else {}

    def removed(self, content: bytes) -> bytes:
        """Return the body of an error without the key; some servers repeat the key, even with JSON escapes."""
        if len(self.key) < SHORTEST:
            return content
        signs = (rf"(?:\\?{re.escape(sign)}|(?i:\\u{ord(sign):04x}))" for sign in self.key)
        return re.sub("".join(signs).encode(), REDACTED, content)

    def removed_from_reply(self, content: bytes) -> bytes:
        """Return the body of a reply without the API key; a short key stays, since it may be a word of the reply."""
        return self.removed(content) if len(self.key) >= SHORTEST_IN_REPLIES else content


def listed_info(served: str, name: str, listing: bytes | None, origin: Origin, *, vision: bool | None) -> ModelInfo:
    """Return a server's facts about a model, from its list of models; `listing` is None if it has no list.

    OpenAI's API has no digest of the weights. Instead, foundry uses a hash of the lasting facts about the model, or of
    the server's address if there are no such facts. Such a hash distinguishes servers, not the weights that a server
    has.
    """
    unlisted: Mapping[str, Any] = {"id": served, "base_url": origin.host}
    row = unlisted if listing is None else _row(listing, served, origin)
    lasting = {key: row[key] for key in (*LASTING, "base_url") if row.get(key) is not None}
    digest, weights = _hash(lasting), _hash(_without_flags(lasting))
    sees = _sees(row) if vision is None else vision
    return ModelInfo(
        name=name,
        digest=digest,
        weights=None if weights == digest else weights,
        capabilities=("completion", *(("vision",) if sees else ())),
        undeclared=("vision",) if sees is None else (),
        measured=True,
        states={origin.host: ""},
        context_length=next(filter(None, (length_in(row.get(key)) for key in LENGTHS)), None),
    )


def is_llama_server(listing: bytes, served: str) -> bool:
    """Return whether a list of models comes from llama.cpp, which describes the weights under `meta`."""
    body = decoded(listing)
    rows = body.get("data") if isinstance(body, dict) else None
    return isinstance(rows, list) and any(
        isinstance(row, dict) and row.get("id") == served and isinstance(row.get("meta"), dict) for row in rows
    )


def loaded_in(props: bytes) -> Loaded:
    """Return the report on llama.cpp's loaded model, from the body of the answer to `GET /props`."""
    body = decoded(props)
    said = body if isinstance(body, dict) else {}
    settings = said.get("default_generation_settings")
    n_ctx = settings.get("n_ctx") if isinstance(settings, dict) else None
    return Loaded(slots=length_in(said.get("total_slots")), context_length=length_in(n_ctx))


def _hash(fields: Mapping[str, Any]) -> str:
    return f"listed-{hashlib.sha256(json.dumps(fields, sort_keys=True).encode()).hexdigest()[:32]}"


def _without_flags(row: Mapping[str, Any]) -> dict[str, Any]:
    fields = {key: value for key, value in row.items() if key not in FLAGS}
    return {key: _without_flags(value) if isinstance(value, Mapping) else value for key, value in fields.items()}


def _row(listing: bytes, served: str, origin: Origin) -> Mapping[str, Any]:
    body = decoded(listing)
    rows = body.get("data") if isinstance(body, dict) else body
    if not isinstance(rows, list):
        advice = "Check model.server.base_url (it often ends with /v1), or set model.server.lists_models=false."
        raise InputError(f"{origin}: GET /models returned no list.", advice=advice)
    listed = {str(row["id"]): row for row in rows if isinstance(row, dict) and "id" in row}
    if served not in listed:
        hint = f"If {origin.host} also serves models that it does not list, use model.server.lists_models=false."
        raise not_found("Model", served, listed, hint)
    row: Mapping[str, Any] = listed[served]
    return row


def _sees(row: Mapping[str, Any]) -> bool | None:
    architecture, capabilities = row.get("architecture"), row.get("capabilities")
    if isinstance(architecture, dict) and isinstance(architecture.get("input_modalities"), list):
        return "image" in architecture["input_modalities"]
    if isinstance(capabilities, dict) and isinstance(capabilities.get("vision"), bool):
        return bool(capabilities["vision"])
    if isinstance(capabilities, list):
        return bool({"vision", "multimodal"} & {str(capability) for capability in capabilities})
    return None
