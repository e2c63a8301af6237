"""What a measure is called, and between which values it can lie."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Measure:
    """What a measure is.

    Attributes:
        label: a few words for tables and axes, with the unit where there is one.
        low: least possible value.
        high: greatest possible value.
    """

    label: str
    low: float = -math.inf
    high: float = math.inf

    def of(self, name: str) -> Measure:
        """Return the measure for one member of its family, `*` in the label replaced by its name."""
        return replace(self, label=self.label.replace("*", name))


def share(label: str) -> Measure:
    """Return a measure that lies between 0 and 1."""
    return Measure(label, 0.0, 1.0)
