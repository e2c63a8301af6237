"""The model part_name: change `ask` to call your own model."""

from typing import Any

from foundry import Model, Reply, Request


class PartName(Model):
    """A model whose calls cost something: answers are cached, and calls are limited and repeated."""

    costs = True

    def __init__(self, name: str, temperature: float) -> None:
        self.name = name
        self._temperature = temperature

    async def ask(self, request: Request) -> Reply:
        """Answer one request.

        Raises:
            TransientError: another try may succeed, for example if the server is busy.
            RequestError: this request can never succeed.
            ServerError: no request can succeed.
        """
        # Call your server here with request.messages and request.seed, and replace this text by its reply.
        return Reply(text='{"message": null, "action": "stay", "memory": "", "reasoning": "made up"}')

    def parameters(self) -> dict[str, Any]:
        """Return everything besides messages and seed that affects the answer; it becomes part of the answer's key."""
        return {"temperature": self._temperature}
