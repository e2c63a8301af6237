"""A person who answers in place of a model, and sees its prompts on a page."""

import re
from collections.abc import Mapping
from typing import Any

from foundry.errors import InputError, ServerError
from foundry.models.base import ModelInfo, Reply, Request
from foundry.models.human.desk import DESK, Desk, Schema
from foundry.models.serving import InFlight, Retry, ServedModel, Serving

MOST_WAITING = 1 << 16
"""Maximum number of questions that wait for people at the same time."""
_NAME = re.compile(r"\w[\w-]{0,39}")


class HumanModel(ServedModel):
    """A person who answers. The cache keeps the answers as for other models, so no person gets a question twice.

    Each call waits for the person without a time limit. In a command without a page, only cached answers exist.
    """

    in_process = True
    replaceable = False
    server = Serving(
        in_flight=InFlight(min=MOST_WAITING, max=MOST_WAITING, initial=MOST_WAITING),
        retry=Retry(attempts=1, unusable_attempts=1, wait_initial_s=1.0, wait_max_s=1.0),
    )

    def __init__(self, *, person: str, name: str, schemas: Mapping[str, Schema] | None = None) -> None:
        """Take the settings that `conf/model/human.yaml` describes."""
        if not _NAME.fullmatch(person):
            raise InputError(
                f"model.person='{person}' is not a valid name: write model=human/<name>, with at most 40 letters, "
                "digits, - and _, such as human/p07."
            )
        self.name = name
        self._person = person
        self._schemas = dict(schemas or {})

    def parameters(self) -> dict[str, Any]:
        """Return the person's name and the choices on the page; the page shows nothing else besides the prompt."""
        return {"person": self._person, "schemas": self._schemas}

    async def inspect(self) -> ModelInfo:
        """Return the capabilities of people: they answer in text and can see images."""
        return ModelInfo(self.name, capabilities=("completion", "vision"))

    async def warm_up(self) -> None:
        """Raise an error if this command shows no page on which people can answer."""
        self._desk()

    async def ask(self, request: Request) -> Reply:
        """Put the question to the person, and wait for the answer."""
        return await self._desk().ask(self._person, request, self._schemas.get(request.kind))

    def _desk(self) -> Desk:
        desk = DESK.get()
        if desk is None:
            raise ServerError(
                f"Person '{self.name}' has not answered everything yet, and can only answer on a page. Continue "
                "with: foundry play <the sweep's folder>"
            )
        return desk
