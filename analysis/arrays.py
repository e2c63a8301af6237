"""The arrays that runs of every form are made of, the outcomes that they hold indices into, and which of them count."""

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
"""What the arrays of outcomes hold indices into."""

READABLE = (OUTCOMES.index(Outcome.CHOSEN), OUTCOMES.index(Outcome.REPAIRED))

STAY = 0
"""The choice that does nothing, among the choices of every form."""


class Decisions:
    """A run of any form as far as its decisions could be read or not; the base of the dataclasses of runs.

    Attributes:
        outcome: of the calls that decided, index into OUTCOMES.
        readable_only: whether the decisions that could not be read are left out of all that is counted.
    """

    outcome: IntArray
    readable_only: bool

    @cached_property
    def readable(self) -> BoolArray:
        """Whether the decision was made by the model, chosen or repaired, in the shape of `outcome`."""
        return np.isin(self.outcome, READABLE)

    @cached_property
    def counted(self) -> BoolArray:
        """Which decisions count, in the shape of `outcome`."""
        return self.readable if self.readable_only else np.ones(self.outcome.shape, dtype=np.bool_)

    @property
    def all_readable(self) -> bool:
        """Whether every decision could be read, so that leaving out the others changes nothing."""
        return bool(self.readable.all())

    def only_readable(self) -> Self:
        """Return the same run with the readable decisions alone counted."""
        found: Self = replace(cast(Any, self), readable_only=True)
        return found
