"""The base class of models that wrap another model."""

from collections.abc import Callable
from typing import Any

from foundry.canary import Canary
from foundry.models.base import Model, ModelInfo


class Wrapper(Model):
    """Passes everything but `ask` on to the wrapped model."""

    def __init__(self, inner: Model) -> None:
        self.inner = inner
        self.name = inner.name
        self.costs = inner.costs

    def parameters(self) -> dict[str, Any]:
        """Return the parameters of the wrapped model."""
        return self.inner.parameters()

    @property
    def kinds(self) -> tuple[str, ...] | None:
        """The kinds of question the wrapped model can answer; None for any."""
        return self.inner.kinds

    @property
    def longest_reply(self) -> int | None:
        """Maximum number of tokens of the wrapped model's replies; None without a limit."""
        return self.inner.longest_reply

    @property
    def context_length(self) -> int | None:
        """Maximum number of tokens of prompt and reply that the wrapped model's settings allow; None without one."""
        return self.inner.context_length

    def next_served(self) -> Callable[[str | None], bool]:
        """Return a function that says whether calls of a run should go to the server with the most room now."""
        return self.inner.next_served()

    async def inspect(self) -> ModelInfo:
        """Ask the wrapped model's server about it."""
        return await self.inner.inspect()

    def canaries(self) -> tuple[Canary, ...]:
        """Return the facts about the wrapped model's weights."""
        return self.inner.canaries()

    async def confirm(self) -> None:
        """Ask the wrapped model's server to confirm it."""
        await self.inner.confirm()

    async def warm_up(self) -> None:
        """Load the wrapped model."""
        await self.inner.warm_up()

    async def unload(self) -> None:
        """Let the wrapped model's server free its memory."""
        await self.inner.unload()

    async def close(self) -> None:
        """Free the wrapped model's connections."""
        await self.inner.close()
