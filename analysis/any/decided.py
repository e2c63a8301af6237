"""Turns decisions into rows of numbers whose mean makes sense: a label becomes a row such as (0, 1, 0)."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Decided:
    """The n counted decisions of one kind, in recorded order; either all are labels or all are numbers.

    Attributes:
        labels: the C possible labels; empty if the decisions are numbers.
        step: 1-based step, (n,).
        agent: agent id, (n,).
        values: for labels, a column per label with 1 for the chosen one and 0 for others, (n, C); for numbers, (n, 1).
    """

    kind: str
    labels: tuple[str, ...]
    step: IntArray
    agent: IntArray
    values: FloatArray

    @cached_property
    def rank(self) -> IntArray:
        """For each decision, the number of earlier steps that have decisions of this kind, (n,)."""
        found: IntArray = np.cumsum(np.diff(self.step, prepend=self.step[:1]) > 0, dtype=np.int64)
        return found

    @property
    def steps(self) -> int:
        """Number of steps with decisions of this kind."""
        return int(self.rank[-1]) + 1 if len(self.rank) else 0

    @cached_property
    def moment(self) -> IntArray:
        """Index of each decision's moment, (n,); only decisions of the same moment are compared.

        A moment is a step. If agents mostly decide alone in a step, as in turns, a moment is a third of the steps with
        decisions of this kind.
        """
        cells = np.unique(self.rank * beyond(self.agent) + self.agent)
        alone = np.bincount(cells // beyond(self.agent)) == 1
        if 2 * int(alone[self.rank].sum()) <= len(self.rank):
            return self.rank
        return np.asarray(self.rank * 3 // self.steps)

    @property
    def counts(self) -> IntArray:
        """Number of decisions with each label, (C,)."""
        return np.asarray(self.values.sum(axis=0), dtype=np.int64)

    def only(self, kept: BoolArray) -> "Decided":
        """Return the decisions for which `kept`, (n,), is true."""
        return Decided(self.kind, self.labels, self.step[kept], self.agent[kept], self.values[kept])


@lru_cache(maxsize=2)
def decided(run: AnyRun) -> tuple[Decided, ...]:
    """Return the decisions of a run for each kind, in the order in which the world declares the kinds.

    If a world declares no actions, the kinds and labels are those that occur, sorted.
    """
    if not run.declared.actions:
        return tuple(_occurring(run))
    return tuple(
        _labels(run, kind, run.kind == kind, actions.labels)
        if actions.labels
        else numbers(run, kind, run.kind == kind, run.number)
        for kind, actions in run.declared.actions.items()
    )


def _occurring(run: AnyRun) -> Iterator[Decided]:
    for kind in sorted(set(run.kind.tolist())):
        own = run.kind == kind
        labels = sorted({one for one in run.action[own].tolist() if one is not None})
        if labels:
            yield _labels(run, kind, own, tuple(labels))
        if not np.isnan(run.number[own]).all():
            yield numbers(run, kind, own, run.number)


def _labels(run: AnyRun, kind: str, own: BoolArray, labels: tuple[str, ...]) -> Decided:
    number = {label: index for index, label in enumerate(labels)}
    codes = np.array([number.get(one, -1) for one in run.action.tolist()], dtype=np.int64)
    kept = own & run.counted & (codes >= 0)
    return Decided(kind, labels, run.step[kept], run.agent[kept], np.eye(len(labels))[codes[kept]])


def numbers(run: AnyRun, kind: str, own: BoolArray, found: FloatArray) -> Decided:
    """Return the counted decisions of one kind whose answer is a number.

    Args:
        run: the run.
        kind: the kind.
        own: which decisions are of this kind, (K,).
        found: a number for each decision, NaN for none, (K,).
    """
    kept = own & run.counted & ~np.isnan(found)
    return Decided(kind, (), run.step[kept], run.agent[kept], found[kept][:, None])


def beyond(ids: IntArray) -> int:
    """Return one more than the greatest id, or 0 without ids."""
    return int(ids.max(initial=-1)) + 1
