"""A backend of one's own, as a user would write it; `_target_` names it."""

import asyncio
from typing import Any, ClassVar

from foundry.errors import TransientError
from foundry.models.base import Model, ModelInfo, Reply, Request
from foundry.models.serving import InFlight, Retry, Serving


class Paid(Model):
    """Costs something and says nothing of how it wants to be asked; its first call fails."""

    costs = True
    asked: ClassVar[list[Request]] = []
    in_flight: ClassVar[int] = 0
    most_in_flight: ClassVar[int] = 0
    digest: ClassVar[str | None] = None

    def __init__(self, name: str) -> None:
        self.name = name

    async def ask(self, request: Request) -> Reply:
        Paid.asked.append(request)
        if len(Paid.asked) == 1:
            raise TransientError("Not yet.")
        Paid.in_flight += 1
        Paid.most_in_flight = max(Paid.most_in_flight, Paid.in_flight)
        await asyncio.sleep(0)
        Paid.in_flight -= 1
        return Reply(text='{"action": "stay", "memory": "", "reasoning": ""}')

    def parameters(self) -> dict[str, Any]:
        return {}

    async def inspect(self) -> ModelInfo:
        return ModelInfo(self.name, digest=self.digest)


class Slow(Paid):
    server = Serving(
        in_flight=InFlight(min=1, max=2, initial=2),
        retry=Retry(attempts=3, unusable_attempts=1, wait_initial_s=0.01, wait_max_s=0.01),
    )
