"""The names and ranges of measures."""

import math
import re
from dataclasses import dataclass, replace

HIGH, LOW = "high", "low"
"""The desired end of a measure."""
_EITHER = re.compile(r"\{([^{}|]*)\|([^{}|]*)\}")


@dataclass(frozen=True)
class Null:
    """The mean of a measure over runs of a policy that ignores the subject of the measure.

    Attributes:
        value: the number.
        policy: the policy with this mean, in words; it may have any other habits.
        by_random: whether `scripted/random` is such a policy; `foundry check` then compares the value with its runs.
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
        label: title for tables and axes, with the unit if any.
        low: least possible value.
        high: greatest possible value.
        null: value by chance alone. None if it depends on the world or on the frequency of actions, or if no chance
            value exists.
        better: HIGH or LOW if the task of the agents or a publication says which end is better; empty for purely
            descriptive measures.
        exclusive: whether it is an outcome of a mutually exclusive family: 1 for the run's outcome, 0 for the others.
            The frequencies are then compared with equal chances.
        outcome: whether it is 1 or 0 in each run, such as whether a crowd reached consensus.
        says: the predicate for a model with a higher or lower value, such as `warns its neighbours {more|less}`; empty
            to use the label.
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
        """Return the predicate for the higher or the lower side; `than` and the other side follow."""
        said = self.says or f"has a {{higher|lower}} value of '{self.label}'"
        return _EITHER.sub(lambda either: either[1 if higher else 2], said)


def share(label: str, null: Null | None = None, better: str = "", says: str = "") -> Measure:
    """Return a measure between 0 and 1."""
    return Measure(label, 0.0, 1.0, null, better, says=says)


def outcome(label: str, better: str = "", says: str = "") -> Measure:
    """Return a measure that is 1 or 0 in each run."""
    return Measure(label, 0.0, 1.0, better=better, outcome=True, says=says)
