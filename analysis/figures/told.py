"""What a picture of values shows, in words, for those who do not see it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from analysis.plots.panel import GroupValues, Scale
from analysis.tables.texts import number, with_interval


def in_words(groups: Sequence[GroupValues], scale: Scale) -> str:
    """Return the means of groups with 95 % intervals, and what they are seen against."""
    means = [f"{one.label} {with_interval(one.mean, one.low, one.high)}" for one in groups]
    marks = [
        f"{what} {number(value)}"
        for what, value in (("chance alone", scale.null), ("the best policy", scale.best))
        if not math.isnan(value)
    ]
    return f"{', '.join([*means, *marks])}."
