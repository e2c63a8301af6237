"""A model that never says anything, so that nothing of a run can be read."""

from __future__ import annotations

from typing import Any

from foundry.models.base import Model, Reply, Request


class Silent(Model):
    """Gives empty replies to every kind of question."""

    def __init__(self, name: str) -> None:
        self.name = name

    async def ask(self, request: Request) -> Reply:
        """Say nothing."""
        return Reply(text="")

    def parameters(self) -> dict[str, Any]:
        """Return nothing: there are no settings."""
        return {}
