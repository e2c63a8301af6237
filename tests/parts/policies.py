"""Scripted models that misbehave, for tests; configured through `_target_` like anybody's own parts."""

from __future__ import annotations

import os

from foundry.models.base import Reply, Request
from foundry.models.scripted.grid import act
from foundry.models.scripted.stay import Stay


def is_doomed(request: Request) -> bool:
    return request.kind == "action" and request.observation["persona"]["fate"] == "doomed"


class Deadly(Stay):
    """Kills its own process when the persona of an agent is `doomed`."""

    def reply(self, request: Request) -> Reply:
        if is_doomed(request):
            os._exit(9)
        return super().reply(request)


class Faulty(Stay):
    """Has a bug that shows when the persona of an agent is `doomed`."""

    def reply(self, request: Request) -> Reply:
        if is_doomed(request):
            raise ZeroDivisionError("a bug")
        return super().reply(request)


class Left(Stay):
    """Goes left, wherever that leads."""

    def reply(self, request: Request) -> Reply:
        return Reply(text=act("left", reasoning="As ever.")) if request.kind == "action" else super().reply(request)
