"""Where two records differ first, and how that is said in one line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

CALLS = "calls.jsonl.zst"
NOTHING = "nothing"
_BEFORE, _LONGEST = 24, 72
"""Characters shown before the first that differs, and in all."""


@dataclass(frozen=True)
class Difference:
    """The first place in which a record is not what it should be.

    Attributes:
        file: name of the file.
        number: its line, from 1; None where the file has no lines.
        field: path of the key in the line; "" for the line as a whole.
        recorded: the recorded value.
        now: the value that replaying gives.
        place: step, agent and kind of the question, where it is one.
    """

    file: str
    number: int | None
    field: str
    recorded: Any
    now: Any
    place: tuple[int, int, str] | None = None

    def line(self) -> str:
        """Return the difference in one line."""
        where = self.file if self.number is None else f"{self.file} line {self.number}"
        if self.place is not None:
            step, agent, kind = self.place
            where += f" (step {step}, agent {agent}, {kind})"
        recorded, now = excerpts(self.recorded, self.now)
        field = f": {self.field}" if self.field else ""
        return f"{where}{field}: recorded {recorded}, now {now}"


def first_difference(recorded: Any, now: Any, path: str = "") -> tuple[str, Any, Any] | None:
    """Return the path of the first value that differs, in the order of the keys, with both values; else None."""
    if isinstance(recorded, Mapping) and isinstance(now, Mapping):
        for key in [*recorded, *(key for key in now if key not in recorded)]:
            inner = f"{path}.{key}" if path else str(key)
            found = first_difference(recorded.get(key, NOTHING), now.get(key, NOTHING), inner)
            if found is not None:
                return found
        return None
    if isinstance(recorded, list | tuple) and isinstance(now, list | tuple):
        for number in range(max(len(recorded), len(now))):
            then, fresh = (part[number] if number < len(part) else NOTHING for part in (recorded, now))
            found = first_difference(then, fresh, f"{path}[{number}]")
            if found is not None:
                return found
        return None
    same = recorded == now and isinstance(recorded, bool) == isinstance(now, bool)
    return None if same else (path, recorded, now)


def excerpts(one: Any, other: Any) -> tuple[str, str]:
    """Return two values in short, texts around the first character that differs."""
    if not (isinstance(one, str) and isinstance(other, str)):
        return _short(repr(one)), _short(repr(other))
    common = next((i for i, pair in enumerate(zip(one, other, strict=False)) if pair[0] != pair[1]), None)
    at = min(len(one), len(other)) if common is None else common
    start = max(0, at - _BEFORE)
    return _excerpt(one, start), _excerpt(other, start)


def _excerpt(text: str, start: int) -> str:
    shown = repr(text[start : start + _LONGEST])
    return f"{'...' if start else ''}{shown}{'...' if start + _LONGEST < len(text) else ''}"


def _short(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
