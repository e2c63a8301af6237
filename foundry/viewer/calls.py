"""Finds the calls of an agent in a compressed log, which is decompressed once and only as far as is asked for."""

from __future__ import annotations

import re
import tempfile
import threading
import weakref
from array import array
from bisect import bisect_left, bisect_right
from pathlib import Path

import numpy as np
import zstandard

READ = 1 << 18
"""Compressed bytes that are read at once."""
BLOCK = 1 << 20
"""Bytes of lines that are kept together, and decompressed together when one of them is asked for."""
_IN_MEMORY = 1 << 25
_HEAD = re.compile(rb'\{"step":(\d+),"agent":(\d+),')


class CallLog:
    """The lines of `calls.jsonl.zst` by step and agent.

    A log is one long stream, which can only be read from its start. What was read is kept in compressed blocks, in
    memory as long as they are small, so that going back costs one block.

    Attributes:
        damaged: why the log cannot be read to its end, or empty; a log cut by a crash is no damage.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._begin()

    def _begin(self) -> None:
        self.damaged = ""
        self._read = 0
        self._rest = b""
        self._inflate = zstandard.ZstdDecompressor().decompressobj()
        self._kept = tempfile.SpooledTemporaryFile(max_size=_IN_MEMORY)  # noqa: SIM115 - closed by close()
        self._free = weakref.finalize(self, self._kept.close)
        self._blocks = array("Q")  # start and length of each in the kept file
        self._lines: list[bytes] = []
        self._open_size = 0
        self._steps, self._agents = array("I"), array("I")
        self._where = array("I")  # block of each line, and its number in it

    def close(self) -> None:
        """Free what was kept; whoever still asks, has it read again."""
        with self._lock:
            self._free()
            self._begin()

    def of_agent(self, agent: int, first: int, last: int) -> list[bytes]:
        """Return the agent's calls of the steps from `first` to `last`, one JSON object each, in their order."""
        return self._find(first, last, agent).get(agent, [])

    def of_all(self, first: int, last: int) -> dict[int, list[bytes]]:
        """Return the calls of these steps by agent."""
        return self._find(first, last, None)

    def _find(self, first: int, last: int, agent: int | None) -> dict[int, list[bytes]]:
        found: dict[int, list[bytes]] = {}
        with self._lock:
            self._read_past(last)
            a, b = bisect_left(self._steps, first), bisect_right(self._steps, last)
            agents = np.array(self._agents[a:b])
            wanted = np.arange(a, b) if agent is None else a + np.flatnonzero(agents == agent)
            opened, lines = -1, self._lines
            for index in wanted.tolist():
                block, number = self._where[2 * index], self._where[2 * index + 1]
                if block != opened:
                    opened, lines = block, self._block(block)
                found.setdefault(self._agents[index], []).append(lines[number])
        return found

    def _read_past(self, step: int) -> None:
        """Read until a later step than this begins, or as far as the log is written."""
        if self.damaged or (self._steps and self._steps[-1] > step):
            return
        try:
            file = self.path.open("rb")
        except FileNotFoundError:
            return
        with file:
            file.seek(self._read)
            while not (self._steps and self._steps[-1] > step):
                chunk = file.read(READ)
                if not chunk or self._inflate.eof:
                    return
                self._read += len(chunk)
                self._take(chunk)

    def _take(self, chunk: bytes) -> None:
        try:
            content = self._inflate.decompress(chunk)
        except zstandard.ZstdError as error:
            self.damaged = str(error)
            return
        *lines, self._rest = (self._rest + content).split(b"\n")
        for line in lines:
            head = _HEAD.match(line)
            if head is None or (self._steps and int(head[1]) < self._steps[-1]):
                self.damaged = f"a call does not begin with its agent and a step that is due: {line[:80]!r}"
                return
            self._steps.append(int(head[1]))
            self._agents.append(int(head[2]))
            self._where.extend((len(self._blocks) // 2, len(self._lines)))
            self._lines.append(line)
            self._open_size += len(line)
            if self._open_size >= BLOCK:
                self._pack()

    def _pack(self) -> None:
        """Compress the open block and begin the next."""
        content = zstandard.ZstdCompressor(level=1).compress(b"\n".join(self._lines))
        start = self._kept.seek(0, 2)
        self._kept.write(content)
        self._blocks.extend((start, len(content)))
        self._lines, self._open_size = [], 0

    def _block(self, block: int) -> list[bytes]:
        """Return the lines of a block; the last one is not compressed yet."""
        if 2 * block == len(self._blocks):
            return self._lines
        self._kept.seek(self._blocks[2 * block])
        content = zstandard.ZstdDecompressor().decompress(self._kept.read(self._blocks[2 * block + 1]))
        return content.split(b"\n")
