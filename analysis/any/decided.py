"""Decisions of a run by kind of question: labels and numbers as rows that can be averaged."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Decided:
    """The n counted decisions of one kind with a label or a number, in recorded order.

    Attributes:
        labels: possible labels, C of them; empty for a number.
        step: 1-based step, (n,).
        agent: agent id, (n,).
        values: one column per label, 1 for the chosen one, else 0, (n, C); or the number, (n, 1).
    """

    kind: str
    labels: tuple[str, ...]
    step: IntArray
    agent: IntArray
    values: FloatArray

    @cached_property
    def rank(self) -> IntArray:
        """Rank of the step among the steps with such decisions, from 0, (n,)."""
        found: IntArray = np.cumsum(np.diff(self.step, prepend=self.step[:1]) > 0, dtype=np.int64)
        return found

    @property
    def steps(self) -> int:
        """Number of steps with such decisions."""
        return int(self.rank[-1]) + 1 if len(self.rank) else 0

    @cached_property
    def moment(self) -> IntArray:
        """Index of the moment, (n,); decisions are compared only within a moment.

        A moment is a step. If agents mostly decide alone in a step, as in turns, a moment is a third of the steps with
        such decisions.
        """
        cells = np.unique(self.rank * beyond(self.agent) + self.agent)
        alone = np.bincount(cells // beyond(self.agent)) == 1
        if 2 * int(alone[self.rank].sum()) <= len(self.rank):
            return self.rank
        return np.asarray(self.rank * 3 // self.steps)

    @property
    def counts(self) -> IntArray:
        """Number of decisions per label, (C,)."""
        return np.asarray(self.values.sum(axis=0), dtype=np.int64)

    def only(self, kept: BoolArray) -> "Decided":
        """Return the decisions selected by a mask (n,)."""
        return Decided(self.kind, self.labels, self.step[kept], self.agent[kept], self.values[kept])


@lru_cache(maxsize=2)
def decided(run: AnyRun) -> tuple[Decided, ...]:
    """Return the decisions of a run by kind, for all declared kinds in their order, even kinds without decisions.

    If a world declares no actions, the kinds and labels are those that occur, sorted.
    """
    return tuple(_declared(run) if run.declared.actions else _occurring(run))


def _declared(run: AnyRun) -> Iterator[Decided]:
    for kind, actions in run.declared.actions.items():
        own = run.kind == kind
        yield _labels(run, kind, own, actions.labels) if actions.labels else _numbers(run, kind, own)


def _occurring(run: AnyRun) -> Iterator[Decided]:
    for kind in sorted(set(run.kind.tolist())):
        own = run.kind == kind
        labels = sorted({one for one in run.action[own].tolist() if one is not None})
        if labels:
            yield _labels(run, kind, own, tuple(labels))
        if not np.isnan(run.number[own]).all():
            yield _numbers(run, kind, own)


def _labels(run: AnyRun, kind: str, own: BoolArray, labels: tuple[str, ...]) -> Decided:
    number = {label: index for index, label in enumerate(labels)}
    codes = np.array([number.get(one, -1) for one in run.action.tolist()], dtype=np.int64)
    kept = own & run.counted & (codes >= 0)
    return Decided(kind, labels, run.step[kept], run.agent[kept], np.eye(len(labels))[codes[kept]])


def _numbers(run: AnyRun, kind: str, own: BoolArray) -> Decided:
    return numbers(run, kind, own & ~np.isnan(run.number), run.number)


def numbers(run: AnyRun, kind: str, own: BoolArray, found: FloatArray) -> Decided:
    """Return the numbers (K,) of the counted decisions of a kind; `own` (K,) marks the kind."""
    kept = own & run.counted
    return Decided(kind, (), run.step[kept], run.agent[kept], found[kept][:, None])


def beyond(ids: IntArray) -> int:
    """Return the lowest number above all ids."""
    return int(ids.max(initial=-1)) + 1
