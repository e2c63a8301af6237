"""Numbers that a world writes beside what is decided, step by step: a line, and how far its values spread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import msgspec

from foundry.declared import Declared
from foundry.viewer.any.streams import OwnStream
from foundry.viewer.lines import StepLines

_NUMBERS = ("integer", "number")
_IDS = ("step", "agent", "sender", "recipient")
_COMMON = ("action", "utility")
"""Numbers of a decision that are shown otherwise."""
_READ = msgspec.json.Decoder(dict[str, Any]).decode_lines


@dataclass(frozen=True)
class Curves:
    """What is drawn on one scale: the numbers of a record file, or one number of the decisions.

    Attributes:
        name: of the file, or of the number.
        keys: the numbers.
        lines: the file.
    """

    name: str
    keys: tuple[str, ...]
    lines: StepLines = field(compare=False)

    @property
    def told(self) -> dict[str, Any]:
        """What the page is told of it."""
        return {"name": self.name, "keys": self.keys}

    def values(self, first: int, last: int) -> list[dict[str, list[float | None]]]:
        """Return of each key, by step from `first` to `last`, `low`, `mean` and `high` of its lines; None for none."""
        self.lines.grow()
        found: dict[tuple[str, int], list[float]] = {}
        for row in _READ(self.lines.read(first, last)):
            for key in self.keys:
                if isinstance(value := row.get(key), int | float):
                    found.setdefault((key, row["step"]), []).append(value)
        return [_by_step([found.get((key, step), []) for step in range(first, last + 1)]) for key in self.keys]


def curves_of(declared: Declared, steps: StepLines, streams: Sequence[OwnStream]) -> tuple[Curves, ...]:
    """Return what can be drawn of a run: of each further file with steps its numbers, then those of the decisions."""
    files = ((one.name, _numbers(declared.streams.get(one.name, {})), one.lines) for one in streams if one.by_step)
    of_files = [Curves(name, keys, lines) for name, keys, lines in files if keys]
    own = (key for key in _numbers(declared.streams.get("steps", {})) if key not in _COMMON)
    return (*of_files, *(Curves(key, (key,), steps) for key in own))


def _numbers(keys: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(key for key, kind in keys.items() if kind.removesuffix("?") in _NUMBERS and key not in _IDS)


def _by_step(values: Sequence[Sequence[float]]) -> dict[str, list[float | None]]:
    return {
        "low": [min(one, default=None) for one in values],
        "mean": [sum(one) / len(one) if one else None for one in values],
        "high": [max(one, default=None) for one in values],
    }
