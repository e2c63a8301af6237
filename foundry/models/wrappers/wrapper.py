"""The common base of models that wrap another model."""

from collections.abc import Callable
from typing import Any

from foundry.canary import Canary
from foundry.models.base import Model, ModelInfo


class Wrapper(Model):
    """Hands everything but `ask` on to the model it wraps."""

    def __init__(self, inner: Model) -> None:
        self.inner = inner
        self.name = inner.name
        self.costs = inner.costs

    def parameters(self) -> dict[str, Any]:
        """Return what decides the wrapped model's answers."""
        return self.inner.parameters()

    @property
    def kinds(self) -> tuple[str, ...] | None:
        """The kinds of question the wrapped model can answer; None for any."""
        return self.inner.kinds

    @property
    def longest_reply(self) -> int | None:
        """Tokens of the wrapped model's longest reply; None where its settings set no limit."""
        return self.inner.longest_reply

    @property
    def context_length(self) -> int | None:
        """Tokens of prompt and reply that the wrapped model's settings make room for; None where they do not say."""
        return self.inner.context_length

    def next_served(self) -> Callable[[str | None], bool]:
        """Return whose calls the wrapped model's server with the most room should get next."""
        return self.inner.next_served()

    async def inspect(self) -> ModelInfo:
        """Ask the wrapped model's server about it."""
        return await self.inner.inspect()

    def canaries(self) -> tuple[Canary, ...]:
        """Return what is known of the weights that answer for the wrapped model."""
        return self.inner.canaries()

    async def confirm(self) -> None:
        """Have the wrapped model's server confirm it."""
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
