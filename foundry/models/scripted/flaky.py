"""A scripted model with faults: it corrupts a given share of another policy's replies.

The attribute `outcome` of a fault is the outcome that the 2D worlds must record for a reply with this fault.
"""

import json
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from foundry.errors import InputError
from foundry.models.base import Reply, Request, ScriptedModel
from foundry.records import Outcome
from foundry.worlds.base import Question


class Fault(ABC):
    """A way to corrupt a reply.

    Attributes:
        outcome: outcome that the world must record for the reply.
        share: share of replies that are corrupted, 0 to 1.
    """

    outcome: ClassVar[Outcome]

    def __init__(self, share: float) -> None:
        if not 0 <= share <= 1:
            raise InputError(f"The share of the fault {type(self).__name__} is {share}. Use a number from 0 to 1.")
        self.share = share

    @abstractmethod
    def spoil(self, text: str) -> Reply:
        """Return the corrupted reply, given the text of a JSON object."""


class Malformed(Fault):
    """JSON without its quotes and colons."""

    outcome = Outcome.UNREADABLE

    def spoil(self, text: str) -> Reply:
        """Remove all quotes and colons."""
        return Reply(text=text.replace('"', "").replace(":", ""))


class Empty(Fault):
    """No text."""

    outcome = Outcome.EMPTY

    def spoil(self, text: str) -> Reply:
        """Remove everything."""
        return Reply(text="")


class Truncated(Fault):
    """A reply that the length limit cuts off in the first value of its JSON object."""

    outcome = Outcome.TRUNCATED

    def spoil(self, text: str) -> Reply:
        """Return a truncated reply: the text up to three characters after its first colon."""
        return Reply(text=text[: text.index(":") + 4], ending="length")


class Fenced(Fault):
    """The JSON is in a code fence, after an introduction."""

    outcome = Outcome.REPAIRED

    def spoil(self, text: str) -> Reply:
        """Add the fence."""
        return Reply(text=f"Here is my decision:\n```json\n{text}\n```")


class ThinkBlock(Fault):
    """The JSON follows a block of thoughts that contains another decision."""

    outcome = Outcome.REPAIRED

    def spoil(self, text: str) -> Reply:
        """Add the thoughts."""
        thoughts = '<think>Perhaps {"action": "stay", "message": "Wait!"}? No.</think>'
        return Reply(text=f"{thoughts}\n{text}")


class SingleQuotes(Fault):
    """A Python dict, with single quotes, in place of JSON."""

    outcome = Outcome.REPAIRED

    def spoil(self, text: str) -> Reply:
        """Write the object as Python does."""
        return Reply(text=repr(json.loads(text)))


class Synonyms(Fault):
    """JSON with synonyms for actions and directions, and with keys in capital letters."""

    outcome = Outcome.REPAIRED

    _WORDS: ClassVar[dict[str, str]] = {
        "stay": "wait",
        "move": "go",
        "up": "north",
        "down": "south",
        "left": "west",
        "right": "east",
    }

    def spoil(self, text: str) -> Reply:
        """Replace the words."""
        reply = json.loads(text)
        for key in ("action", "direction"):
            if key in reply:
                reply[key] = self._WORDS.get(reply[key], reply[key])
        return Reply(text=json.dumps({key.capitalize(): value for key, value in reply.items()}))


class Flaky(ScriptedModel):
    """Returns the replies of another policy, some of them corrupted."""

    def __init__(self, name: str, policy: ScriptedModel, faults: Mapping[str, Fault]) -> None:
        """Wrap a policy.

        Args:
            name: name of the model.
            policy: policy whose replies are corrupted.
            faults: faults by name; the sum of their shares is at most 1.
        """
        super().__init__(
            name, of=policy.parameters(), faults={type(fault).__name__: fault.share for fault in faults.values()}
        )
        self.policy = policy
        self.faults = tuple(faults.values())
        total = sum(fault.share for fault in self.faults)
        if total > 1 + 1e-9:
            raise InputError(f"The shares of model.faults add up to {total:g}, but may add up to at most 1.")

    @property
    def kinds(self) -> tuple[str, ...] | None:
        """The kinds of question that the wrapped policy can answer."""
        return self.policy.kinds

    def check(self, question: Question) -> None:
        """Raise an error for a question that the wrapped policy cannot answer."""
        self.policy.check(question)

    def reply(self, request: Request) -> Reply:
        """Answer one request."""
        reply = self.policy.reply(request)
        fault = self._drawn_fault(request)
        return reply if fault is None else fault.spoil(reply.text)

    def _drawn_fault(self, request: Request) -> Fault | None:
        draw = float(self.generator(request).random())
        for fault in self.faults:
            draw -= fault.share
            if draw < 0:
                return fault
        return None
