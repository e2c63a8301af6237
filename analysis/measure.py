"""Describes measures: their titles, possible values and nulls."""

import math
import re
from dataclasses import dataclass, replace

HIGH, LOW = "high", "low"
"""The values of `Measure.better`: whether a high or a low value of a measure is better."""
_EITHER = re.compile(r"\{([^{}|]*)\|([^{}|]*)\}")


@dataclass(frozen=True)
class Null:
    """The mean of a measure over runs of a policy that ignores what the measure is about.

    Attributes:
        policy: the policy, in words; its other habits do not matter.
        by_random: whether `scripted/random` is such a policy; `foundry check` then compares its runs with the value.
    """

    value: float
    policy: str
    by_random: bool = True

    def __str__(self) -> str:
        return f"{self.value:g}: {self.policy}"


@dataclass(frozen=True)
class Measure:
    """The description of a measure.

    Attributes:
        label: title for tables and axes, with the unit.
        low: least possible value.
        high: greatest possible value.
        null: value by chance. None if it depends on the world or on the frequency of actions, or if there is none.
        better: HIGH or LOW if the agents' task or a publication says which end is better; else "".
        exclusive: whether it is one of several mutually exclusive outcomes: 1 for the run's outcome, 0 for the others.
            The frequencies of these outcomes are compared with equal chances.
        outcome: whether it is 1 or 0 in each run, such as consensus in a crowd.
        says: predicate of a model with a higher (first word) or lower value, such as `warns its neighbours
            {more|less}`; by default made from the label.
    """

    label: str
    low: float = -math.inf
    high: float = math.inf
    null: Null | None = None
    better: str = ""
    exclusive: bool = False
    outcome: bool = False
    says: str = ""

    def of(self, name: str) -> "Measure":
        """Return the measure for one place, action and so on: its name replaces `*` in the title and in sentences."""
        return replace(self, label=self.label.replace("*", name), says=self.says.replace("*", name))

    def phrase(self, higher: bool) -> str:
        """Return the predicate for the higher or the lower side, such as `warns its neighbours more`."""
        said = self.says or f"has a {{higher|lower}} value of '{self.label}'"
        return _EITHER.sub(lambda either: either[1 if higher else 2], said)


def share(label: str, null: Null | None = None, better: str = "", says: str = "") -> Measure:
    """Return a measure between 0 and 1."""
    return Measure(label, 0.0, 1.0, null, better, says=says)


def outcome(label: str, better: str = "", says: str = "") -> Measure:
    """Return a measure that is 1 or 0 in each run."""
    return Measure(label, 0.0, 1.0, better=better, outcome=True, says=says)
