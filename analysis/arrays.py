"""The arrays that runs of every form are made of, and the outcomes that they hold indices into."""

from __future__ import annotations

from typing import TypeAlias

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
