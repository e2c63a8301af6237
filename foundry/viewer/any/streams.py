"""What a world writes beside its steps, for tables and curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import msgspec

from foundry.declared import Declared
from foundry.storing.store import RunFolder
from foundry.viewer.lines import StepLines

MOST_BYTES = 1 << 20
"""Of a stream whose lines have no step, so much is shown."""
_SHOWN_ELSEWHERE = ("steps", "agents")
_BY_STEP = b'{"step":'


@dataclass(frozen=True)
class OwnStream:
    """One record file beside the steps.

    Attributes:
        name: its name without its ending.
        keys: the keys of its lines, as far as they are declared.
        by_step: whether its lines begin with their step.
        lines: the file.
    """

    name: str
    keys: tuple[str, ...]
    by_step: bool
    lines: StepLines = field(compare=False)

    @property
    def told(self) -> dict[str, Any]:
        """What the page is told of it."""
        return {"name": self.name, "keys": self.keys, "by_step": self.by_step}

    def rows(self, first: int, last: int) -> list[msgspec.Raw]:
        """Return its lines of these steps as they are; of lines without steps, the first ones."""
        if not self.by_step:
            return _raw(_whole(_head(self.lines)))
        self.lines.grow()
        return _raw(self.lines.read(first, last))


def streams_of(folder: RunFolder) -> tuple[OwnStream, ...]:
    """Return what a run has beside its steps: what its world declared, else the files that hold something."""
    found = (_stream(folder, name) for name in folder.streams if name not in _SHOWN_ELSEWHERE)
    return tuple(one for one in found if one.keys or _head(one.lines))


def _stream(folder: RunFolder, name: str) -> OwnStream:
    keys = tuple(folder.declared.streams.get(name, ()))
    lines = StepLines(folder.stream_path(name))
    by_step = keys[0] == "step" if keys else _head(lines).startswith(_BY_STEP)
    return OwnStream(name, keys, by_step, lines)


def _head(lines: StepLines) -> bytes:
    try:
        with lines.path.open("rb") as file:
            return file.read(MOST_BYTES)
    except FileNotFoundError:
        return b""


def _whole(content: bytes) -> bytes:
    return content[: content.rfind(b"\n") + 1]


def _raw(lines: bytes) -> list[msgspec.Raw]:
    return [msgspec.Raw(line) for line in lines.splitlines()]


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
