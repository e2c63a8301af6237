"""What a measure is called, and between which values it can lie."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Null:
    """What a measure comes to, in the mean over runs, where nothing of what it is about is going on.

    Attributes:
        value: the number.
        policy: whose it is: a policy that answers as this says, whatever else it does.
    """

    value: float
    policy: str

    def __str__(self) -> str:
        return f"{self.value:g}: {self.policy}"


@dataclass(frozen=True)
class Measure:
    """What a measure is.

    Attributes:
        label: a few words for tables and axes, with the unit where there is one.
        low: least possible value.
        high: greatest possible value.
        null: what chance alone gives; None where that depends on the world, on how often agents do something, or on
            nothing that could be called chance.
    """

    label: str
    low: float = -math.inf
    high: float = math.inf
    null: Null | None = None

    def of(self, name: str) -> Measure:
        """Return the measure for one member of its family, `*` in the label replaced by its name."""
        return replace(self, label=self.label.replace("*", name))


def share(label: str, null: Null | None = None) -> Measure:
    """Return a measure that lies between 0 and 1."""
    return Measure(label, 0.0, 1.0, null)
