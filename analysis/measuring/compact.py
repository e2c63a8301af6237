"""The measures of one run, as small as they can be held: a sweep may have thousands of runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache

import numpy as np

from analysis.arrays import FloatArray


class Values(Mapping[str, float]):
    """Values by `<signature>.<measure>`; runs that have the same measures share their names.

    Attributes:
        names: the measures, in their order (M).
        array: their values (M,).
    """

    __slots__ = ("_positions", "array", "names")

    def __init__(self, found: Mapping[str, float]) -> None:
        self.names, self._positions = _shared(tuple(found))
        self.array: FloatArray = np.fromiter(found.values(), dtype=np.float64, count=len(found))

    def __getitem__(self, name: str) -> float:
        return float(self.array[self._positions[name]])

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


@lru_cache(maxsize=64)
def _shared(names: tuple[str, ...]) -> tuple[tuple[str, ...], dict[str, int]]:
    return names, {name: index for index, name in enumerate(names)}
