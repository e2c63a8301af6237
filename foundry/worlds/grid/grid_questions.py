"""What agents of the 2D world are asked, and who hears what they say."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from foundry.records import Message
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


def deliveries(
    step: int, said: Iterable[tuple[int, MessageReading]], neighbours: Iterable[Iterable[int]]
) -> list[Message]:
    """Return who hears what at a step, by sender and recipient.

    Args:
        step: 1-based step.
        said: senders with what they said; silence is heard by nobody.
        neighbours: those whom each sender can talk to, in the order of the senders.
    """
    return [
        Message(step=step, sender=sender, recipient=recipient, text=reading.text)
        for (sender, reading), hearers in zip(said, neighbours, strict=True)
        if reading.text is not None
        for recipient in hearers
    ]


def heard(message: Message) -> dict[str, Any]:
    """Return a delivered message as its recipient keeps it."""
    return {"sender": message.sender, "text": message.text}
