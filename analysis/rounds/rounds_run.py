"""One recorded run of a world in rounds as arrays of decisions, for T rounds and N agents."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, TypeVar

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.arrays import BoolArray, FloatArray, IntArray, TextArray

Values = TypeVar("Values", BoolArray, IntArray, FloatArray)
NONE = -1
"""Index of the choice of a decision that chose nothing."""


@dataclass(frozen=True)
class RoundsRun(AnyRun):
    """One complete run; if an agent decides a question several times in a round, the last decision counts.

    Attributes:
        columns: values of the keys that only this world's decisions have, (K,) each, for K recorded decisions.
        streams: lines of the files that only this world declares, by the file's name.
    """

    columns: Mapping[str, TextArray] = field(default_factory=dict)
    streams: Mapping[str, Sequence[Mapping[str, Any]]] = field(default_factory=dict)

    @classmethod
    def of(cls, run: AnyRun, **further: Any) -> "RoundsRun":
        """Convert a run of any form to a run in rounds."""
        return cls(**{field.name: getattr(run, field.name) for field in fields(run)}, **further)

    @property
    def steps(self) -> int:
        """Number of rounds, T."""
        return int(self.step.max(initial=0))

    def was_read(self, kind: str) -> BoolArray:
        """Return whether each decision of this kind was readable, (T, N)."""
        return self.placed(kind, self.readable, fill=False)

    def counts(self, kind: str) -> BoolArray:
        """Return whether each decision of this kind counts, (T, N)."""
        return self.placed(kind, self.counted, fill=False)

    def choices(self, kind: str) -> IntArray:
        """Return the decisions as indices into the declared labels, (T, N).

        As in the rules, an unreadable decision is the idle choice, or NONE in worlds without an idle choice. Agents
        that were not asked also have NONE.
        """
        known = self.declared.actions[kind]
        places = {label: place for place, label in enumerate(known.labels)}
        idle = places.get(str(known.idle), NONE)
        choices = [places.get(label, idle) for label in self.action.tolist()]
        return self.placed(kind, np.array(choices, dtype=np.int64), fill=NONE)

    def numbers(self, kind: str) -> FloatArray:
        """Return the decided numbers, (T, N); an unreadable decision counts as the idle number, if any, else NaN."""
        idle = self.declared.actions[kind].idle
        default = float(idle) if isinstance(idle, int | float) else np.nan
        return self.placed(kind, np.where(np.isnan(self.number), default, self.number), fill=np.nan)

    def column(self, kind: str, key: str) -> FloatArray:
        """Return the values of one key of the decisions as numbers, (T, N); NaN where a value is null."""
        values = np.array(
            [np.nan if column is None else column for column in self.columns[key].tolist()], dtype=np.float64
        )
        return self.placed(kind, values, fill=np.nan)

    def shares(self, kind: str) -> dict[str, FloatArray]:
        """Return the share of each label among the counted decisions of a round, (T,) each; NaN without decisions."""
        choices, counts = self.choices(kind), self.counts(kind)
        total = counts.sum(axis=1)
        chosen = [(counts & (choices == place)).sum(axis=1) for place in range(len(self.declared.actions[kind].labels))]
        return {
            label: np.divide(share, total, out=np.full(self.steps, np.nan), where=total > 0)
            for label, share in zip(self.declared.actions[kind].labels, chosen, strict=True)
        }

    def means(self, kind: str) -> FloatArray:
        """Return the mean of the counted numbers of a round, (T,); NaN without numbers."""
        numbers = np.where(self.counts(kind), self.numbers(kind), np.nan)
        known = ~np.isnan(numbers)
        total = known.sum(axis=1)
        means: FloatArray = np.full(self.steps, np.nan)
        np.divide(np.nansum(numbers, axis=1), total, out=means, where=total > 0)
        return means

    def placed(self, kind: str, values: Values, *, fill: float) -> Values:
        """Arrange values of decisions, (K,), by round and agent, (T, N); agents that were not asked get `fill`."""
        own = self.kind == kind
        placed = np.full((self.steps, self.agents), fill, dtype=values.dtype)
        placed[self.step[own] - 1, self.agent[own]] = values[own]
        return placed
