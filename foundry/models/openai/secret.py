"""The key of a server: read from the environment, sent in a header, kept out of everything that is written."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field

from foundry.errors import InputError

VARIABLE = re.compile(r"(?:[A-Z][A-Z0-9_]*_)?API_KEY")
"""Names that are accepted: no service's keys look like that, and a sweep's settings, which may come from someone
else, can name no other secret of the environment."""
SHORTEST = 8
"""Shorter keys are placeholders such as `EMPTY`, which stand in errors as words."""
SHORTEST_IN_REPLIES = 12
"""Shorter ones are words that a model may well say."""
REDACTED = b"[key]"


@dataclass(frozen=True)
class Secret:
    """A key, or none.

    Attributes:
        key: the key; empty where there is none.
    """

    key: str = field(repr=False)

    @classmethod
    def from_environment(cls, variable: str | None) -> Secret:
        """Return the key that the environment variable holds, or none where it is not set.

        Raises:
            InputError: this is no name of a variable, or its value no key; neither is repeated.
        """
        if variable is None:
            return cls("")
        if not VARIABLE.fullmatch(variable):
            raise InputError(
                "model.server.api_key_env must be the name of an environment variable that ends with API_KEY: "
                "put the key in one, such as OPENAI_API_KEY, and give that name."
            )
        key = os.environ.get(variable, "").strip()
        if not key.isascii() or not key.isprintable() or " " in key:
            raise InputError(f"What {variable} holds is no key: it has spaces or signs that no header can hold.")
        return cls(key)

    @property
    def headers(self) -> dict[str, str]:
        """The headers that carry the key."""
        return {"authorization": f"Bearer {self.key}"} if self.key else {}

    def removed(self, content: bytes) -> bytes:
        """Return a refusal without the key, which some servers repeat, also in the escapes of JSON."""
        if len(self.key) < SHORTEST:
            return content
        signs = (rf"(?:\\?{re.escape(sign)}|(?i:\\u{ord(sign):04x}))" for sign in self.key)
        return re.sub("".join(signs).encode(), REDACTED, content)

    def removed_from_reply(self, content: bytes) -> bytes:
        """Return a reply without the key, unless it is a placeholder."""
        return self.removed(content) if len(self.key) >= SHORTEST_IN_REPLIES else content
