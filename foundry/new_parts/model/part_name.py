"""The model part_name: change `ask` to call what you have."""

from typing import Any

from foundry import Model, Reply, Request


class PartName(Model):
    """Answers of its own; what it said is cached, limited and tried again as for every model that costs something."""

    costs = True

    def __init__(self, name: str, temperature: float) -> None:
        self.name = name
        self._temperature = temperature

    async def ask(self, request: Request) -> Reply:
        """Answer one request.

        Raises:
            TransientError: another try may succeed, as when the server is busy.
            RequestError: this request can never succeed.
            ServerError: no request can succeed.
        """
        # Call your server here with request.messages and request.seed, and put the text of its reply in place of this.
        return Reply(text='{"message": null, "action": "stay", "memory": "", "reasoning": "made up"}')

    def parameters(self) -> dict[str, Any]:
        """Return everything beside messages and seed that decides the answer: it is part of the answer's key."""
        return {"temperature": self._temperature}
