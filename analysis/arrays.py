"""The types of arrays, and the outcomes of decisions, for runs of all forms."""

from dataclasses import replace
from functools import cached_property
from typing import Any, Self, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from foundry.records import Outcome

IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]
FloatArray: TypeAlias = NDArray[np.float64]
TextArray: TypeAlias = NDArray[np.object_]

OUTCOMES = tuple(Outcome)
"""The outcomes, in the order of the indices in arrays of outcomes."""

READABLE = (OUTCOMES.index(Outcome.CHOSEN), OUTCOMES.index(Outcome.REPAIRED))

STAY = 0
"""Index of the choice that does nothing, in all forms."""


class Decisions:
    """Base of the classes of runs: says which decisions are readable, and which decisions measures count.

    Attributes:
        outcome: outcome of each call, an index into OUTCOMES.
        readable_only: whether measures leave out unreadable decisions.
    """

    outcome: IntArray
    readable_only: bool

    @cached_property
    def readable(self) -> BoolArray:
        """True for readable decisions, with the outcome `chosen` or `repaired`, in the shape of `outcome`."""
        return np.isin(self.outcome, READABLE)

    @cached_property
    def counted(self) -> BoolArray:
        """True for decisions that measures count: all, or only readable ones; in the shape of `outcome`."""
        return self.readable if self.readable_only else np.ones(self.outcome.shape, dtype=np.bool_)

    @property
    def all_readable(self) -> bool:
        """True if all decisions are readable."""
        return bool(self.readable.all())

    def only_readable(self) -> Self:
        """Return a copy of the run in which measures count only readable decisions."""
        copy: Self = replace(cast(Any, self), readable_only=True)
        return copy
