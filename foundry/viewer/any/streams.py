"""The record files that only one world writes; the page shows them as tables and curves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import msgspec

from foundry.declared import Declared
from foundry.storing.store import RunFolder
from foundry.viewer.lines import StepLines
from foundry.viewer.run_view import raw

MOST_BYTES = 1 << 20
"""The page shows at most this many bytes of a file whose lines have no step."""
_SHOWN_ELSEWHERE = ("steps", "agents")
_BY_STEP = b'{"step":'


@dataclass(frozen=True)
class OwnStream:
    """A record file other than `steps.jsonl`.

    Attributes:
        name: name of the file without its ending.
        keys: the declared keys of its lines.
        by_step: whether each line begins with its step.
    """

    name: str
    keys: tuple[str, ...]
    by_step: bool
    lines: StepLines = field(compare=False)

    @property
    def told(self) -> dict[str, Any]:
        """The name of this record file, its keys, and whether its lines have steps, as the page gets them."""
        return {"name": self.name, "keys": self.keys, "by_step": self.by_step}

    def rows(self, first: int, last: int) -> list[msgspec.Raw]:
        """Return the lines from step `first` to `last`, or the first lines of the file if its lines have no step."""
        if not self.by_step:
            head = _head(self.lines)
            return raw(head[: head.rfind(b"\n") + 1].splitlines())
        self.lines.grow()
        return raw(self.lines.read(first, last).splitlines())


def streams_of(folder: RunFolder) -> tuple[OwnStream, ...]:
    """Return the world's own record files of a run; a file without declared keys is left out while it is empty."""
    streams = (_stream(folder, name) for name in folder.streams if name not in _SHOWN_ELSEWHERE)
    return tuple(stream for stream in streams if stream.keys or _head(stream.lines))


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


_NUMBERS = ("integer", "number")
_IDS = ("step", "agent", "sender", "recipient")
_COMMON = ("action", "utility")
"""Numbers of a decision that are no curve here, because another part of the page shows them."""
_READ = msgspec.json.Decoder(dict[str, Any]).decode_lines


@dataclass(frozen=True)
class Curves:
    """Curves over time with one common scale: the numbers of a world's own record file, or one number of `steps.jsonl`.

    Attributes:
        name: name of the file or of the number.
        keys: keys of the numbers.
    """

    name: str
    keys: tuple[str, ...]
    lines: StepLines = field(compare=False)

    @property
    def told(self) -> dict[str, Any]:
        """The name of this group of curves and the keys of its curves, as the page gets them."""
        return {"name": self.name, "keys": self.keys}

    def values(self, first: int, last: int) -> list[dict[str, list[float | None]]]:
        """Return, for each key, the `low`, `mean` and `high` value of each step; None for a step without a value."""
        self.lines.grow()
        values: dict[tuple[str, int], list[float]] = {}
        for row in _READ(self.lines.read(first, last)):
            for key in self.keys:
                if isinstance(value := row.get(key), int | float):
                    values.setdefault((key, row["step"]), []).append(value)
        return [_by_step([values.get((key, step), []) for step in range(first, last + 1)]) for key in self.keys]


def curves_of(declared: Declared, steps: StepLines, streams: Sequence[OwnStream]) -> tuple[Curves, ...]:
    """Return the groups of curves of a run: one per record file of the world, then one per number of `steps.jsonl`."""
    files = (
        (stream.name, _numbers(declared.streams.get(stream.name, {})), stream.lines)
        for stream in streams
        if stream.by_step
    )
    of_files = [Curves(name, keys, lines) for name, keys, lines in files if keys]
    own = (key for key in _numbers(declared.streams.get("steps", {})) if key not in _COMMON)
    return (*of_files, *(Curves(key, (key,), steps) for key in own))


def _numbers(keys: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(key for key, kind in keys.items() if kind.removesuffix("?") in _NUMBERS and key not in _IDS)


def _by_step(values: Sequence[Sequence[float]]) -> dict[str, list[float | None]]:
    return {
        "low": [min(value, default=None) for value in values],
        "mean": [sum(value) / len(value) if value else None for value in values],
        "high": [max(value, default=None) for value in values],
    }
