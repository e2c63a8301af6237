"""Turns decisions into rows of numbers whose mean makes sense: a label becomes a row such as (0, 1, 0)."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class DecisionsOfKind:
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
        moments: IntArray = np.cumsum(np.diff(self.step, prepend=self.step[:1]) > 0, dtype=np.int64)
        return moments

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

    def only(self, rows: BoolArray) -> "DecisionsOfKind":
        """Return the decisions for which `rows`, (n,), is true."""
        return DecisionsOfKind(self.kind, self.labels, self.step[rows], self.agent[rows], self.values[rows])


@lru_cache(maxsize=2)
def decided(run: AnyRun) -> tuple[DecisionsOfKind, ...]:
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


def _occurring(run: AnyRun) -> Iterator[DecisionsOfKind]:
    for kind in sorted(set(run.kind.tolist())):
        own = run.kind == kind
        labels = sorted({label for label in run.action[own].tolist() if label is not None})
        if labels:
            yield _labels(run, kind, own, tuple(labels))
        if not np.isnan(run.number[own]).all():
            yield numbers(run, kind, own, run.number)


def _labels(run: AnyRun, kind: str, own: BoolArray, labels: tuple[str, ...]) -> DecisionsOfKind:
    number = {label: index for index, label in enumerate(labels)}
    codes = np.array([number.get(label, -1) for label in run.action.tolist()], dtype=np.int64)
    counted = own & run.counted & (codes >= 0)
    return DecisionsOfKind(kind, labels, run.step[counted], run.agent[counted], np.eye(len(labels))[codes[counted]])


def numbers(run: AnyRun, kind: str, own: BoolArray, given_numbers: FloatArray) -> DecisionsOfKind:
    """Return the counted decisions of one kind whose answer is a number.

    Args:
        run: the run.
        kind: the kind.
        own: which decisions are of this kind, (K,).
        given_numbers: a number for each decision, NaN for none, (K,).
    """
    counted = own & run.counted & ~np.isnan(given_numbers)
    return DecisionsOfKind(kind, (), run.step[counted], run.agent[counted], given_numbers[counted][:, None])


def beyond(ids: IntArray) -> int:
    """Return one more than the greatest id, or 0 without ids."""
    return int(ids.max(initial=-1)) + 1
