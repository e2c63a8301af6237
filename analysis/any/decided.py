"""What was decided in a run, by kind of question: labels and numbers as rows of numbers that can be averaged."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Decided:
    """The n decisions of one kind that count and say a label, or a number, in the order of the records.

    Attributes:
        kind: of the question.
        labels: what could be decided, C of them; empty for a number.
        step: 1-based step, (n,).
        agent: agent id, (n,).
        values: by label 1 where it was decided and else 0, (n, C); the number, (n, 1).
    """

    kind: str
    labels: tuple[str, ...]
    step: IntArray
    agent: IntArray
    values: FloatArray

    @cached_property
    def rank(self) -> IntArray:
        """Number of the step among those that have such decisions, from 0, (n,)."""
        found: IntArray = np.cumsum(np.diff(self.step, prepend=self.step[:1]) > 0, dtype=np.int64)
        return found

    @property
    def steps(self) -> int:
        """Number of steps that have such decisions."""
        return int(self.rank[-1]) + 1 if len(self.rank) else 0

    @cached_property
    def moment(self) -> IntArray:
        """Number of the moment, (n,): decisions are compared with those of others at the same moment.

        A moment is a step. Where most decisions are of agents that are alone in their step, as in turns, it is a third
        of the steps that have such decisions.
        """
        cells = np.unique(self.rank * beyond(self.agent) + self.agent)
        alone = np.bincount(cells // beyond(self.agent)) == 1
        if 2 * int(alone[self.rank].sum()) <= len(self.rank):
            return self.rank
        return np.asarray(self.rank * 3 // self.steps)

    @property
    def counts(self) -> IntArray:
        """How often each label was decided, (C,)."""
        return np.asarray(self.values.sum(axis=0), dtype=np.int64)

    def only(self, kept: BoolArray) -> "Decided":
        """Return those of the decisions that are kept (n,)."""
        return Decided(self.kind, self.labels, self.step[kept], self.agent[kept], self.values[kept])


@lru_cache(maxsize=2)
def decided(run: AnyRun) -> tuple[Decided, ...]:
    """Return what was decided by kind, those that are declared in their order, with or without any decision.

    A world that declares no actions has the kinds and the labels that occur, by the alphabet.
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
    """Return those numbers (K,) whose decisions are of a kind, `own` (K,), and count."""
    kept = own & run.counted
    return Decided(kind, (), run.step[kept], run.agent[kept], found[kept][:, None])


def beyond(ids: IntArray) -> int:
    """Return the least number above all ids."""
    return int(ids.max(initial=-1)) + 1
