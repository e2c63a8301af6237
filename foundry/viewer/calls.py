"""Finds the calls of an agent in a compressed log, and reads as little of the log as possible."""

import mmap
import re
import threading
from bisect import bisect_left
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import zstandard

READ = 1 << 16
"""Number of compressed bytes that are read at once."""
HEAD_READ = 1 << 12
"""Number of bytes at the beginning of a Zstandard frame that are read to find its first step."""
_HEAD = re.compile(rb'\{"step":(\d+),"agent":(\d+),')
_LONGEST_HEADER = 18
"""Maximum size of the header of a Zstandard frame, bytes."""


class _LoggedCall(NamedTuple):
    """A logged call: `lines[start:end]` is the call's own line, among decompressed lines of a Zstandard frame."""

    frame: int
    step: int
    agent: int
    lines: bytes
    start: int
    end: int

    @property
    def line(self) -> bytes:
        """The call itself."""
        return self.lines[self.start : self.end]


class CallLog:
    """The lines of `calls.jsonl.zst` by step and agent.

    The writer ends a Zstandard frame after some megabytes of lines, so the first line of each frame shows where a step
    is. Earlier versions wrote a single long frame, which is read from its start. Reading goes on from the last position
    if a later step is wanted.

    Attributes:
        damaged: reason why the log cannot be read to its end, or "". A log that a crash cut off is not damaged.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._begin()

    def _begin(self) -> None:
        self.damaged = ""
        self._starts: list[int] = []
        self._first_steps: dict[int, int] = {}
        self._calls: Iterator[_LoggedCall] = iter(())
        self._next: _LoggedCall | None = None

    def close(self) -> None:
        """Free the memory; the next request reads the log again."""
        with self._lock:
            self._begin()

    def of_agent(self, agent: int, first: int, last: int) -> list[bytes]:
        """Return the calls of an agent from step `first` to `last`, in order, each as a line of JSON."""
        return self._find(first, last, agent).get(agent, [])

    def of_all(self, first: int, last: int) -> dict[int, list[bytes]]:
        """Return the calls in these steps by agent, as lines of JSON."""
        return self._find(first, last, None)

    def _find(self, first: int, last: int, agent: int | None) -> dict[int, list[bytes]]:
        lines_by_agent: dict[int, list[bytes]] = {}
        with self._lock:
            self._go_to(first)
            while self._next is not None and self._next.step <= last:
                if self._next.step >= first and agent in (None, self._next.agent):
                    lines_by_agent.setdefault(self._next.agent, []).append(self._next.line)
                self._next = next(self._calls, None)
        return lines_by_agent

    def _go_to(self, step: int) -> None:
        """Move the reading position, `self._next`, to the first call of a step or to an earlier call."""
        self._look_for_frames()
        frame = max(0, bisect_left(range(len(self._starts)), step, key=self._first_step) - 1)
        if self._next is None or self._next.step > step or self._next.frame < frame:
            self._calls = self._read_from(frame)
            self._next = next(self._calls, None)

    def _look_for_frames(self) -> None:
        """Find where Zstandard frames begin. The last known frame is read again, as it may have grown."""
        known = self._starts.pop() if self._starts else 0
        if self.path.exists() and self.path.stat().st_size:
            with self.path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as log:
                self._starts += frame_starts(log, known)

    def _first_step(self, frame: int) -> int:
        if frame not in self._first_steps:
            with self.path.open("rb") as file:
                file.seek(self._starts[frame])
                try:
                    beginning = zstandard.ZstdDecompressor().stream_reader(file, read_size=HEAD_READ).read(HEAD_READ)
                except zstandard.ZstdError:
                    beginning = b""
            head = _HEAD.match(beginning)
            if head is None:
                return 1 << 62  # not written yet, or damaged, which its reader reports
            self._first_steps[frame] = int(head[1])
        return self._first_steps[frame]

    def _read_from(self, frame: int) -> Iterator[_LoggedCall]:
        """Yield all calls from the beginning of a Zstandard frame, until the log ends or a part of it is damaged."""
        step = 0
        while frame < len(self._starts):  # which grows
            try:
                for lines in self._lines(frame):
                    start = 0
                    while end := lines.find(b"\n", start) + 1:
                        head = _HEAD.match(lines, start)
                        if head is None or int(head[1]) < step:
                            line = lines[start : min(end - 1, start + 80)]
                            self.damaged = (
                                f"a call has no agent, no step, or a lower step than the call before: {line!r}"
                            )
                            return
                        step = int(head[1])
                        yield _LoggedCall(frame, step, int(head[2]), lines, start, end - 1)
                        start = end
            except zstandard.ZstdError as error:
                self.damaged = str(error)
                return
            frame += 1

    def _lines(self, frame: int) -> Iterator[bytes]:
        """Yield the lines of a Zstandard frame in blocks of many lines.

        The last line of a block may be incomplete; then the next block begins with this line as a whole.
        """
        inflate = zstandard.ZstdDecompressor().decompressobj()
        rest = b""
        with self.path.open("rb") as file:
            file.seek(self._starts[frame])
            while not inflate.eof and (chunk := file.read(READ)):
                lines = rest + inflate.decompress(chunk)
                yield lines
                rest = lines[lines.rfind(b"\n") + 1 :]


def frame_starts(log: mmap.mmap, start: int) -> list[int]:
    """Return the byte position at which each Zstandard frame of a log begins; the search begins at byte `start`.

    The last frame may be incomplete.

    Source of the layout: RFC 8878, section 3.1.1.
    """
    starts = []
    while start < len(log):
        starts.append(start)
        try:
            header = log[start : start + _LONGEST_HEADER]
            place = start + zstandard.frame_header_size(header)
            has_checksum = zstandard.get_frame_parameters(header).has_checksum
        except zstandard.ZstdError:  # damaged, which its reader reports
            return starts
        is_last = False
        while not is_last:
            head = int.from_bytes(log[place : place + 3], "little")
            is_last, kind, size = bool(head & 1), head >> 1 & 3, head >> 3
            place += 3 + (1 if kind == 1 else size)  # a repeated byte, or the bytes themselves
            if place > len(log) or (place == len(log) and not is_last):
                return starts
        start = place + 4 * has_checksum
    return starts
