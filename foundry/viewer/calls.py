"""Finds the calls of an agent in a compressed log, and reads as little of it as possible."""

import mmap
import re
import threading
from bisect import bisect_left
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import zstandard

READ = 1 << 16
"""Number of compressed bytes per read."""
HEAD_READ = 1 << 12
"""Number of bytes that are read of a frame to find its first step."""
_HEAD = re.compile(rb'\{"step":(\d+),"agent":(\d+),')
_LONGEST_HEADER = 18
"""Maximum size of a frame's header, bytes."""


class _LoggedCall(NamedTuple):
    """A call, and the position of its line within lines of a frame."""

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

    The writer ends a Zstandard frame after some megabytes of lines. A step is found by the first line of each frame. A
    log with a single long frame, as earlier versions wrote it, is read from its start. Later steps are read from the
    last position on.

    Attributes:
        damaged: reason why the log cannot be read to its end, or ""; a log cut by a crash is not damaged.
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
        """Discard the cached data; later calls read the log again."""
        with self._lock:
            self._begin()

    def of_agent(self, agent: int, first: int, last: int) -> list[bytes]:
        """Return the agent's calls in the steps from `first` to `last`, one JSON object each, in order."""
        return self._find(first, last, agent).get(agent, [])

    def of_all(self, first: int, last: int) -> dict[int, list[bytes]]:
        """Return the calls of the given steps by agent."""
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
        """Move to or before the first call of a step."""
        self._look_for_frames()
        frame = max(0, bisect_left(range(len(self._starts)), step, key=self._first_step) - 1)
        if self._next is None or self._next.step > step or self._next.frame < frame:
            self._calls = self._read_from(frame)
            self._next = next(self._calls, None)

    def _look_for_frames(self) -> None:
        """Find the starts of the frames that have been written; the last frame may grow."""
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
        """Yield the calls from a frame on, up to damage or the end of the written log."""
        step = 0
        while frame < len(self._starts):  # which grows
            try:
                for lines in self._lines(frame):
                    start = 0
                    while end := lines.find(b"\n", start) + 1:
                        head = _HEAD.match(lines, start)
                        if head is None or int(head[1]) < step:
                            line = lines[start : min(end - 1, start + 80)]
                            self.damaged = f"a call does not begin with its agent and a step that is due: {line!r}"
                            return
                        step = int(head[1])
                        yield _LoggedCall(frame, step, int(head[2]), lines, start, end - 1)
                        start = end
            except zstandard.ZstdError as error:
                self.damaged = str(error)
                return
            frame += 1

    def _lines(self, frame: int) -> Iterator[bytes]:
        """Yield the lines of a frame in batches; the last line may be incomplete."""
        inflate = zstandard.ZstdDecompressor().decompressobj()
        rest = b""
        with self.path.open("rb") as file:
            file.seek(self._starts[frame])
            while not inflate.eof and (chunk := file.read(READ)):
                lines = rest + inflate.decompress(chunk)
                yield lines
                rest = lines[lines.rfind(b"\n") + 1 :]


def frame_starts(log: mmap.mmap, start: int) -> list[int]:
    """Return the starts of the Zstandard frames in a log; the last frame may be incomplete.

    Source of the layout: RFC 8878, section 3.1.1.

    Args:
        log: the log.
        start: start of a frame; earlier frames are skipped.
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
