"""Finds the lines of a step in a file of JSON lines, which may be large and may still grow."""

import re
import threading
from bisect import bisect_left, bisect_right
from pathlib import Path

from foundry.errors import RecordError

BLOCK = 1 << 22
"""Number of bytes that are read at once."""
NEAR = 1 << 10
"""To find the last line of a step, the search first jumps this number of bytes beyond the step's first line."""
_STEP = re.compile(rb'\{"step":(\d+)')
_AGENT = re.compile(rb'\{"step":\d+,"agent":(\d+),')


class StepLines:
    """Finds the lines of each step in a file. The file may not exist yet.

    Steps must never decrease in the file. An incomplete last line is ignored.
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
        """Read the lines that were completed since the last call; raise RecordError if a line has no step."""
        with self._lock:
            try:
                file = self.path.open("rb")
            except FileNotFoundError:
                return
            with file:
                if file.seek(0, 2) < self._end:  # the run was restarted
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
        """The number of the last step, and how many lines this step has; (0, 0) if there are no lines."""
        return self._counted(-1)

    @property
    def in_first(self) -> int:
        """Number of lines of the first step; 0 if the file has no lines."""
        return self._counted(0)[1]

    def _counted(self, place: int) -> tuple[int, int]:
        """Return the step at an index of the list of steps, and the number of lines of this step."""
        with self._lock:
            if not self._steps:
                return 0, 0
            step = self._steps[place]
        return step, self.read(step, step).count(b"\n")

    def read(self, first: int, last: int) -> bytes:
        """Return the raw lines of the steps from `first` to `last`."""
        with self._lock:
            a, b = bisect_left(self._steps, first), bisect_right(self._steps, last)
            if a == b:
                return b""
            start, end = self._starts[a], self._starts[b] if b < len(self._starts) else self._end
        with self.path.open("rb") as file:
            file.seek(start)
            return file.read(end - start)

    def _index(self, block: bytes, whole: int) -> None:
        """Find by bisection where each step begins in the first `whole` bytes of a block, and store the positions."""
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
        """Return the position after the lines of a step, given the position `low` at which one of them begins."""
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
    """Return the lines of one agent in the order of the file.

    Each line begins with its `step` and its `agent`. No text can look like the beginning of a line, because line breaks
    in texts are escaped.
    """
    return re.findall(rb'\n(\{"step":\d+,"agent":%d,[^\n]*)' % agent, b"\n" + lines)


def by_agent(lines: bytes) -> dict[int, list[bytes]]:
    """Return the lines of each agent in the order of the file, by the id of the agent."""
    by_id: dict[int, list[bytes]] = {}
    for line in lines.splitlines():
        match = _AGENT.match(line)
        if match is not None:
            by_id.setdefault(int(match[1]), []).append(line)
    return by_id


_STEP_AND_AGENT = re.compile(rb'\n\{"step":\d+,"agent":(\d+)[,}]')


class DecisionLines(StepLines):
    """Finds the lines of each step in a file in which every line begins with its step and its agent.

    Attributes:
        agents: the highest id of an agent so far, plus one.
    """

    def _begin(self) -> None:
        super()._begin()
        self.agents = 0

    def _index(self, block: bytes, whole: int) -> None:
        matches = _STEP_AND_AGENT.findall(b"\n" + block[:whole])
        if len(matches) != block.count(b"\n", 0, whole):
            raise RecordError(f"{self.path}: a line does not begin with its step and its agent.")
        super()._index(block, whole)
        self.agents = max(self.agents, *(int(agent) + 1 for agent in set(matches)), 0)
