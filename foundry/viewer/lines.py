"""Finds the lines of a step in a file of JSON lines that may be large, and may still be written."""

from __future__ import annotations

import re
import threading
from bisect import bisect_left, bisect_right
from pathlib import Path

import numpy as np

from foundry.errors import RecordError

BLOCK = 1 << 22
"""Bytes that are looked through at once."""
_STEP = re.compile(rb'\{"step":(\d+)')
_AGENT = re.compile(rb'\{"step":\d+,"agent":(\d+),')
_NEWLINE = 10


class StepLines:
    """Where the lines of each step are; steps never go down in a file. Only whole lines are seen.

    Attributes:
        path: the file; it may not be there yet.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._begin()

    def _begin(self) -> None:
        self._steps: list[int] = []
        self._starts: list[int] = []
        self._counts: list[int] = []
        self._end = 0

    def grow(self) -> None:
        """Take in the whole lines that were written since the last look.

        Raises:
            RecordError: a line does not begin with its step.
        """
        with self._lock:
            try:
                file = self.path.open("rb")
            except FileNotFoundError:
                return
            with file:
                if file.seek(0, 2) < self._end:  # the run was started anew
                    self._begin()
                file.seek(self._end)
                rest = b""
                while block := file.read(BLOCK):
                    block = rest + block
                    cut = block.rfind(b"\n") + 1
                    self._index(block[:cut])
                    rest = block[cut:]

    def counts(self, first: int, last: int) -> dict[int, int]:
        """Return how many lines there are of each step from `first` to `last`, of those that have any."""
        with self._lock:
            a, b = bisect_left(self._steps, first), bisect_right(self._steps, last)
            return dict(zip(self._steps[a:b], self._counts[a:b], strict=True))

    @property
    def last(self) -> tuple[int, int]:
        """The last step that has a line, and how many it has; (0, 0) when there is none."""
        with self._lock:
            return (self._steps[-1], self._counts[-1]) if self._steps else (0, 0)

    @property
    def in_first(self) -> int:
        """How many lines the first step has; 0 when there is none."""
        with self._lock:
            return self._counts[0] if self._counts else 0

    def read(self, first: int, last: int) -> bytes:
        """Return the lines of the steps from `first` to `last`, as they are."""
        with self._lock:
            a, b = bisect_left(self._steps, first), bisect_right(self._steps, last)
            if a == b:
                return b""
            start, end = self._starts[a], self._starts[b] if b < len(self._starts) else self._end
        with self.path.open("rb") as file:
            file.seek(start)
            return file.read(end - start)

    def _index(self, block: bytes) -> None:
        """Add a block of whole lines; the first line of each step is found by bisection."""
        ends = np.flatnonzero(np.frombuffer(block, dtype=np.uint8) == _NEWLINE) + 1
        starts = [0, *ends[:-1].tolist()] if len(ends) else []
        final = self._step_at(block, starts[-1]) if starts else 0
        line = 0
        while line < len(starts):
            step = self._step_at(block, starts[line])
            if step > final:
                raise RecordError(f"{self.path}: step {final} comes after step {step}.")
            after = bisect_right(starts, step, lo=line, key=lambda start: self._step_at(block, start))
            self._add(step, self._end + starts[line], after - line)
            line = after
        self._end += len(block)

    def _add(self, step: int, start: int, count: int) -> None:
        if self._steps and self._steps[-1] == step:
            self._counts[-1] += count
            return
        if self._steps and self._steps[-1] > step:
            raise RecordError(f"{self.path}: step {step} comes after step {self._steps[-1]}.")
        self._steps.append(step)
        self._starts.append(start)
        self._counts.append(count)

    def _step_at(self, block: bytes, start: int) -> int:
        match = _STEP.match(block, start)
        if match is None:
            raise RecordError(f"{self.path}: a line does not begin with its step: {block[start : start + 80]!r}")
        return int(match[1])


def lines_of_agent(lines: bytes, agent: int) -> list[bytes]:
    """Return the lines of one agent, in their order.

    The keys of a record stand in the order of its fields, `step` and `agent` first; line breaks inside texts are
    escaped, so that no text can look like the beginning of a line.
    """
    return re.findall(rb'\n(\{"step":\d+,"agent":%d,[^\n]*)' % agent, b"\n" + lines)


def by_agent(lines: bytes) -> dict[int, list[bytes]]:
    """Return the lines of every agent, in their order."""
    found: dict[int, list[bytes]] = {}
    for line in lines.splitlines():
        match = _AGENT.match(line)
        if match is not None:
            found.setdefault(int(match[1]), []).append(line)
    return found
