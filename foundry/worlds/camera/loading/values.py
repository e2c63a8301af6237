"""What a stage's attributes hold, each value checked for what it is read as, and what cannot be drawn of a file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, TypeVar

import numpy as np
from pxr import Sdf, Tf

from foundry.worlds.camera.loading.scene import FloatArray, IntArray

EXAMPLES = 5


class Findings:
    """Counts things by kind; the first few of each kind are named."""

    def __init__(self) -> None:
        self._seen: dict[str, dict[str, None]] = {}

    def add(self, kind: str, example: str) -> None:
        """Note one more thing of this kind, found at `example`; the same example counts once."""
        self._seen.setdefault(kind, {})[example] = None

    def lines(self) -> Iterator[str]:
        """Yield one line for each kind, in the order in which they were found."""
        for kind, examples in self._seen.items():
            rest = len(examples) - EXAMPLES
            more = f" and {rest} more" if rest > 0 else ""
            yield f"{kind}: {'; '.join(list(examples)[:EXAMPLES])}{more}"


LARGEST = 1e15
"""Numbers beyond this are taken as wrong: no scene holds any, and their squares must still be numbers."""


_Default = TypeVar("_Default")


class Values:
    """Reads attributes at one time; a value that is not of the kind asked for is named, and counts as not there.

    Attributes:
        time: when.
    """

    def __init__(self, findings: Findings, time: Any) -> None:
        self.time = time
        self._findings = findings

    def number(self, attribute: Any | None, default: float) -> float:
        """Return a number."""
        value = self._value(attribute)
        if value is None:
            return default
        if isinstance(value, (int, float)) and abs(value) <= LARGEST:
            return float(value)
        return self._wrong(attribute, default)

    def flag(self, attribute: Any | None, default: bool) -> bool:
        """Return a truth value, which some files write as a number."""
        return bool(self.number(attribute, default))

    def vector(self, attribute: Any | None, width: int) -> tuple[float, ...] | None:
        """Return the first so many numbers, or None where there is no such value."""
        value = self._value(attribute)
        if value is None:
            return None
        numbers = _numbers(value)
        if numbers is None or numbers.ndim != 1 or len(numbers) < width or not _are_sound(numbers):
            return self._wrong(attribute, None)
        return tuple(numbers[:width].tolist())

    def text(self, attribute: Any | None, default: str) -> str:
        """Return a text or a token."""
        value = self._value(attribute)
        if value is None or isinstance(value, str):
            return default if value is None else value
        return self._wrong(attribute, default)

    def first_text(self, attribute: Any) -> str:
        """Return the first of several texts, or the empty one."""
        value = self._value(attribute)
        if value is None:
            return ""
        texts: list[Any] = [None] if isinstance(value, str) or not isinstance(value, Iterable) else list(value)
        if not all(isinstance(one, str) for one in texts):
            return self._wrong(attribute, "")
        return str(texts[0]) if texts else ""

    def asset(self, attribute: Any | None) -> Any:
        """Return the path of a file."""
        value = self._value(attribute)
        if value is None or isinstance(value, Sdf.AssetPath):
            return value or Sdf.AssetPath()
        return self._wrong(attribute, Sdf.AssetPath())

    def triples(self, attribute: Any) -> FloatArray | None:
        """Return (n, 3) numbers, which may be infinite or NaN; None for a value of another kind."""
        value = self._value(attribute)
        numbers = np.zeros(0) if value is None else _numbers(value)
        if numbers is None or not (numbers.shape == (0,) or (numbers.ndim == 2 and numbers.shape[1] == 3)):
            return self._wrong(attribute, None)
        return numbers.reshape(-1, 3)

    def indices(self, attribute: Any) -> IntArray | None:
        """Return (n,) whole numbers; None for a value of another kind."""
        value = self._value(attribute)
        numbers = np.zeros(0) if value is None else np.asarray(value)
        if numbers.ndim != 1 or (numbers.size and numbers.dtype.kind not in "iu"):
            return self._wrong(attribute, None)
        return numbers.astype(np.int64)

    def flattened(self, primvar: Any) -> FloatArray | None:
        """Return the (n, k) values of a primvar, its indices resolved; None, and named, where they are no numbers."""
        numbers = _numbers(self._computed(primvar))
        if numbers is None or not _are_sound(numbers):
            return self._wrong(primvar.GetAttr(), None)
        rows = numbers.shape[0] if numbers.ndim else 1
        return numbers.reshape(rows, -1) if numbers.size else np.zeros((0, 1))

    def _computed(self, primvar: Any) -> Any:
        try:
            value = primvar.ComputeFlattened(self.time)
        except Tf.ErrorException:
            return None
        return np.zeros(0) if value is None else value

    def _value(self, attribute: Any | None) -> Any:
        return attribute.Get(self.time) if attribute else None

    def _wrong(self, attribute: Any, default: _Default) -> _Default:
        self._findings.add("Value of a wrong kind", str(attribute.GetPath()))
        return default


def _numbers(value: Any) -> FloatArray | None:
    """Return a value of USD as an array of numbers, or None where it holds anything else."""
    if isinstance(value, str):
        return None
    numbers = np.asarray(value)
    return np.asarray(numbers, np.float64) if numbers.dtype.kind in "fiub" else None


def _are_sound(numbers: FloatArray) -> bool:
    """Return whether all numbers are finite and of a size that can be reckoned with."""
    return bool((np.abs(numbers) <= LARGEST).all())
