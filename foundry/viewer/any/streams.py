"""What a world writes beside its steps, for tables."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import msgspec

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
