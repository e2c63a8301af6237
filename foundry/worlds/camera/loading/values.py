"""Reads a stage's attributes, checks the types of their values, and notes content that cannot be drawn."""

from collections.abc import Iterable, Iterator
from typing import Any, TypeVar

import numpy as np
from pxr import Sdf, Tf

from foundry.worlds.camera.loading.scene import FloatArray, IntArray

EXAMPLES = 5


class Findings:
    """Collects content that cannot be drawn, by kind, with the first few examples of each kind."""

    def __init__(self) -> None:
        self._seen: dict[str, dict[str, None]] = {}

    def add(self, kind: str, example: str) -> None:
        """Add an example of this kind of content that cannot be drawn; the same example counts once."""
        self._seen.setdefault(kind, {})[example] = None

    def lines(self) -> Iterator[str]:
        """Yield one line for each kind, in the order in which the kinds were first found."""
        for kind, examples in self._seen.items():
            rest = len(examples) - EXAMPLES
            more = f" and {rest} more" if rest > 0 else ""
            yield f"{kind}: {'; '.join(list(examples)[:EXAMPLES])}{more}"


LARGEST = 1e15
"""Largest number that is accepted in a USD file. No scene needs more, and the square of a larger number could be
infinite.
"""

_Default = TypeVar("_Default")


class Values:
    """Reads the values that attributes have at one time code; reports a value of a wrong type and ignores it."""

    def __init__(self, findings: Findings, time: Any) -> None:
        self.time = time
        self._findings = findings

    def number(self, attribute: Any | None, default: float) -> float:
        """Return an attribute's number, or the default without one."""
        value = self._value(attribute)
        if value is None:
            return default
        if isinstance(value, (int, float)) and abs(value) <= LARGEST:
            return float(value)
        return self._wrong(attribute, default)

    def flag(self, attribute: Any | None, default: bool) -> bool:
        """Return an attribute that is true or false; some files write it as a number."""
        return bool(self.number(attribute, default))

    def vector(self, attribute: Any | None, width: int) -> tuple[float, ...] | None:
        """Return the first `width` numbers of an attribute, or None if it has fewer."""
        value = self._value(attribute)
        if value is None:
            return None
        numbers = _numbers(value)
        if numbers is None or numbers.ndim != 1 or len(numbers) < width or not _are_sound(numbers):
            return self._wrong(attribute, None)
        return tuple(numbers[:width].tolist())

    def text(self, attribute: Any | None, default: str) -> str:
        """Return an attribute's text or token, or the default without one."""
        value = self._value(attribute)
        if value is None or isinstance(value, str):
            return default if value is None else value
        return self._wrong(attribute, default)

    def first_text(self, attribute: Any) -> str:
        """Return the first text of an attribute that lists texts; "" if there is none."""
        value = self._value(attribute)
        if value is None:
            return ""
        texts: list[Any] = [None] if isinstance(value, str) or not isinstance(value, Iterable) else list(value)
        if not all(isinstance(text, str) for text in texts):
            return self._wrong(attribute, "")
        return str(texts[0]) if texts else ""

    def asset(self, attribute: Any | None) -> Any:
        """Return an attribute's file, as an asset path of USD; its path is empty without one."""
        value = self._value(attribute)
        if value is None or isinstance(value, Sdf.AssetPath):
            return value or Sdf.AssetPath()
        return self._wrong(attribute, Sdf.AssetPath())

    def triples(self, attribute: Any) -> FloatArray | None:
        """Return an attribute's (n, 3) numbers, which may be infinite or NaN; None for a value of another type."""
        value = self._value(attribute)
        numbers = np.zeros(0) if value is None else _numbers(value)
        if numbers is None or not (numbers.shape == (0,) or (numbers.ndim == 2 and numbers.shape[1] == 3)):
            return self._wrong(attribute, None)
        return numbers.reshape(-1, 3)

    def indices(self, attribute: Any) -> IntArray | None:
        """Return an attribute's whole numbers (n,); None if its value has another type."""
        value = self._value(attribute)
        numbers = np.zeros(0) if value is None else np.asarray(value)
        if numbers.ndim != 1 or (numbers.size and numbers.dtype.kind not in "iu"):
            return self._wrong(attribute, None)
        return numbers.astype(np.int64)

    def flattened(self, primvar: Any) -> FloatArray | None:
        """Return the values (n, k) of a primvar, one per index if it has indices; None if the values are no numbers."""
        try:
            value = primvar.ComputeFlattened(self.time)
            numbers = np.zeros(0) if value is None else _numbers(value)
        except Tf.ErrorException:
            numbers = None
        if numbers is None or not _are_sound(numbers):
            return self._wrong(primvar.GetAttr(), None)
        rows = numbers.shape[0] if numbers.ndim else 1
        return numbers.reshape(rows, -1) if numbers.size else np.zeros((0, 1))

    def _value(self, attribute: Any | None) -> Any:
        return attribute.Get(self.time) if attribute else None

    def _wrong(self, attribute: Any, default: _Default) -> _Default:
        self._findings.add("Value of a wrong kind", str(attribute.GetPath()))
        return default


def _numbers(value: Any) -> FloatArray | None:
    """Return a value of USD as an array of numbers, or None if it contains anything else."""
    if isinstance(value, str):
        return None
    numbers = np.asarray(value)
    return np.asarray(numbers, np.float64) if numbers.dtype.kind in "fiub" else None


def _are_sound(numbers: FloatArray) -> bool:
    return bool((np.abs(numbers) <= LARGEST).all())
