"""One recorded run of a round-based world as arrays: every decision by round and agent.

T rounds, N agents.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, TypeVar

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.arrays import BoolArray, FloatArray, IntArray, TextArray

Values = TypeVar("Values", BoolArray, IntArray, FloatArray)
NONE = -1
"""Index for no choice."""


@dataclass(frozen=True)
class RoundsRun(AnyRun):
    """One complete run; if an agent decides a question several times in a round, the last decision counts.

    Attributes:
        columns: declared keys of the decisions that are not common to all forms, (K,) each.
        streams: lines of the further declared files, by stream.
    """

    columns: Mapping[str, TextArray] = field(default_factory=dict)
    streams: Mapping[str, Sequence[Mapping[str, Any]]] = field(default_factory=dict)

    @classmethod
    def of(cls, run: AnyRun, **further: Any) -> "RoundsRun":
        """Convert a run of any form to one of rounds."""
        return cls(**{field.name: getattr(run, field.name) for field in fields(run)}, **further)

    @property
    def steps(self) -> int:
        """Number of rounds, T."""
        return int(self.step.max(initial=0))

    def was_read(self, kind: str) -> BoolArray:
        """Return which decisions of this kind are readable, (T, N)."""
        return self.placed(kind, self.readable, fill=False)

    def counts(self, kind: str) -> BoolArray:
        """Return which decisions of this kind count, (T, N)."""
        return self.placed(kind, self.counted, fill=False)

    def choices(self, kind: str) -> IntArray:
        """Return the decisions as indices into the declared labels, (T, N).

        An unreadable decision counts as the idle choice, as in the rules. NONE marks agents without a question, and
        unreadable decisions in worlds without an idle choice.
        """
        known = self.declared.actions[kind]
        places = {label: place for place, label in enumerate(known.labels)}
        idle = places.get(str(known.idle), NONE)
        found = [places.get(label, idle) for label in self.action.tolist()]
        return self.placed(kind, np.array(found, dtype=np.int64), fill=NONE)

    def numbers(self, kind: str) -> FloatArray:
        """Return the decided numbers, (T, N); an unreadable decision is the idle number, if declared, else NaN."""
        idle = self.declared.actions[kind].idle
        default = float(idle) if isinstance(idle, int | float) else np.nan
        return self.placed(kind, np.where(np.isnan(self.number), default, self.number), fill=np.nan)

    def column(self, kind: str, key: str) -> FloatArray:
        """Return a further key of the decisions of a kind as numbers, (T, N); NaN where there is none."""
        values = np.array([np.nan if one is None else one for one in self.columns[key].tolist()], dtype=np.float64)
        return self.placed(kind, values, fill=np.nan)

    def shares(self, kind: str) -> dict[str, FloatArray]:
        """Return the share of each label among the counted decisions, by round, (T,); NaN without any."""
        choices, counts = self.choices(kind), self.counts(kind)
        total = counts.sum(axis=1)
        chosen = [(counts & (choices == place)).sum(axis=1) for place in range(len(self.declared.actions[kind].labels))]
        return {
            label: np.divide(one, total, out=np.full(self.steps, np.nan), where=total > 0)
            for label, one in zip(self.declared.actions[kind].labels, chosen, strict=True)
        }

    def means(self, kind: str) -> FloatArray:
        """Return the mean number of the counted decisions, by round, (T,); NaN without any."""
        numbers = np.where(self.counts(kind), self.numbers(kind), np.nan)
        known = ~np.isnan(numbers)
        total = known.sum(axis=1)
        found: FloatArray = np.full(self.steps, np.nan)
        np.divide(np.nansum(numbers, axis=1), total, out=found, where=total > 0)
        return found

    def placed(self, kind: str, values: Values, *, fill: float) -> Values:
        """Return values (K,) of the decisions of a kind as (T, N), with a fill value for agents without a question."""
        own = self.kind == kind
        found = np.full((self.steps, self.agents), fill, dtype=values.dtype)
        found[self.step[own] - 1, self.agent[own]] = values[own]
        return found
