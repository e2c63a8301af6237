"""Finds the lines of a step in a file of JSON lines that may be large, and may still be written."""

from __future__ import annotations

import re
import threading
from bisect import bisect_left, bisect_right
from pathlib import Path

from foundry.errors import RecordError

BLOCK = 1 << 22
"""Bytes that are looked through at once."""
NEAR = 1 << 10
"""Bytes behind its first line in which the end of a step is looked for first."""
_STEP = re.compile(rb'\{"step":(\d+)')
_AGENT = re.compile(rb'\{"step":\d+,"agent":(\d+),')


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
                size = BLOCK
                while block := file.read(size):
                    whole = block.rfind(b"\n") + 1
                    self._index(block, whole)
                    if len(block) < size:
                        return
                    size = BLOCK if whole else 2 * size
                    file.seek(self._end)

    @property
    def last(self) -> tuple[int, int]:
        """The last step that has a line, and how many it has; (0, 0) when there is none."""
        return self._counted(-1)

    @property
    def in_first(self) -> int:
        """How many lines the first step has; 0 when there is none."""
        return self._counted(0)[1]

    def _counted(self, place: int) -> tuple[int, int]:
        """Return the step at a place in the list of steps, and how many lines it has."""
        with self._lock:
            if not self._steps:
                return 0, 0
            step = self._steps[place]
        return step, self.read(step, step).count(b"\n")

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

    def _index(self, block: bytes, whole: int) -> None:
        """Add the whole lines of a block, which end at a byte; where a step ends is found by bisection."""
        start, final = 0, self._step_at(block, block.rfind(b"\n", 0, whole - 1) + 1) if whole else 0
        while start < whole:
            step = self._step_at(block, start)
            if step > final:
                raise RecordError(f"{self.path}: step {final} comes after step {step}.")
            after = self._end_of(step, block, start, whole)
            self._add(step, self._end + start)
            start = after
        self._end += whole

    def _end_of(self, step: int, block: bytes, low: int, high: int) -> int:
        """Return where the lines of a step end between its line at `low` and `high`, looked for near `low` first."""
        reach = NEAR
        while True:
            middle = min(low + reach, (low + high) // 2)
            start = block.rfind(b"\n", low, middle) + 1 or block.find(b"\n", middle) + 1
            if start >= high:
                return high
            if self._step_at(block, start) > step:
                high = start
            else:
                low, reach = start, 2 * reach

    def _add(self, step: int, start: int) -> None:
        if self._steps and self._steps[-1] > step:
            raise RecordError(f"{self.path}: step {step} comes after step {self._steps[-1]}.")
        if not self._steps or self._steps[-1] < step:
            self._steps.append(step)
            self._starts.append(start)

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


_STEP_AND_AGENT = re.compile(rb'\n\{"step":\d+,"agent":(\d+)[,}]')


class DecisionLines(StepLines):
    """Lines that begin with their step and their agent.

    Attributes:
        agents: number of agents that have a line so far, those with lower ids included.
    """

    def _begin(self) -> None:
        super()._begin()
        self.agents = 0

    def _index(self, block: bytes, whole: int) -> None:
        found = _STEP_AND_AGENT.findall(b"\n" + block[:whole])
        if len(found) != block.count(b"\n", 0, whole):
            raise RecordError(f"{self.path}: a line does not begin with its step and its agent.")
        super()._index(block, whole)
        self.agents = max(self.agents, *(int(agent) + 1 for agent in set(found)), 0)
