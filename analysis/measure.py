"""The names and ranges of measures."""

import math
import re
from dataclasses import dataclass, replace

HIGH, LOW = "high", "low"
"""The end of a measure that agents are to reach."""
_EITHER = re.compile(r"\{([^{}|]*)\|([^{}|]*)\}")


@dataclass(frozen=True)
class Null:
    """The mean of a measure over runs of a policy that ignores the subject of the measure.

    Attributes:
        value: the number.
        policy: whose it is: a policy that answers as this says, whatever else it does.
        by_random: whether `scripted/random` answers so; `foundry check` then holds the value against its runs.
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
        label: a few words for tables and axes, with the unit where there is one.
        low: least possible value.
        high: greatest possible value.
        null: what chance alone gives; None where that depends on the world, on how often agents do something, or on
            nothing that could be called chance.
        better: HIGH or LOW where the task that agents are told, or what is published of it, says which end is better;
            empty for what only says how they behave.
        exclusive: whether it is of a family of outcomes of which each run has exactly one, 1 for that and 0 for the
            others; how often each comes is then held against equal chances.
        outcome: whether it is 1 or 0 in each run, such as that a crowd reached consensus.
        says: what is said of a model in which it is higher or lower, such as `warns its neighbours {more|less}`; empty
            where the label must do.
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
        """Return the measure for one member of its family, `*` in the label replaced by its name."""
        return replace(self, label=self.label.replace("*", name), says=self.says.replace("*", name))

    def phrase(self, higher: bool) -> str:
        """Return what is said of who is higher in it, or lower; `than` and the other are to follow."""
        said = self.says or f"has a {{higher|lower}} value of '{self.label}'"
        return _EITHER.sub(lambda either: either[1 if higher else 2], said)


def share(label: str, null: Null | None = None, better: str = "", says: str = "") -> Measure:
    """Return a measure that lies between 0 and 1."""
    return Measure(label, 0.0, 1.0, null, better, says=says)


def outcome(label: str, better: str = "", says: str = "") -> Measure:
    """Return a measure that is 1 or 0 in each run."""
    return Measure(label, 0.0, 1.0, better=better, outcome=True, says=says)
