"""How the questions of the 2D world are made from what an agent perceives, keeps and has decided."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from foundry.worlds.base import Question
from foundry.worlds.grid.parsing import MessageReading

MESSAGE, ACTION = "message", "action"
IDLE = {
    MESSAGE: json.dumps({"message": None, "reasoning": "I keep to myself."}),
    ACTION: json.dumps({"action": "stay", "memory": "", "reasoning": "I stay where I am."}),
}
"""The replies that do nothing."""


def question(
    perceived: dict[str, Any],
    memories: Iterable[str],
    received: Iterable[dict[str, Any]],
    said: MessageReading | None,
) -> Question:
    """Return what an agent is asked: for a message, or for an action once it has said what it has to say.

    Args:
        perceived: its observation before the move.
        memories: its own, oldest first.
        received: messages from others, oldest first.
        said: its message at this step; None before that.
    """
    observation = perceived | {"memory": list(memories), "received": list(received)}
    if said is not None:
        observation["message"] = said.text
    kind = MESSAGE if said is None else ACTION
    return Question(perceived["step"], perceived["agent"], kind, observation, idle=IDLE[kind])
