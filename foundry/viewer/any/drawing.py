"""The pictures of a run: those that were kept, and those that its world draws again from the records."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from foundry.errors import FoundryError, InputError
from foundry.storing.store import RunFolder, frame_name, kept_file

if TYPE_CHECKING:
    from foundry.replay.recording import Recording
    from foundry.worlds.base import Redrawing

EXPORTED_S = 10.0
"""An export draws the pictures of a run if all of them take no longer, seconds."""
_KEPT = re.compile(r"frames/step_(\d+)\.png")
_ONE_AT_A_TIME = threading.Lock()  # what worlds draw with can seldom draw from two threads


class Drawing:
    """Gives pictures of a run; what is read for them is kept until the run grows.

    Args:
        folder: the run.
        trusted: further packages whose classes its world may be built of.
    """

    def __init__(self, folder: RunFolder, trusted: Sequence[str]) -> None:
        self._folder = folder
        self._trusted = trusted
        self._read: tuple[str, Recording, Redrawing] | None = None

    def kept(self) -> list[int]:
        """Return the steps whose pictures were kept, ascending."""
        found = (_KEPT.fullmatch(name) for name in self._folder.pictures())
        return sorted(int(match[1]) for match in found if match)

    def why_not(self) -> str:
        """Return why no pictures can be drawn, in one line; empty where they can."""
        try:
            self._drawn(0)
        except FoundryError as error:
            return str(error)
        return ""

    def shows_lanes(self) -> bool:
        """Return whether the pictures show only lanes, as the page does; not where nobody may ask the world."""
        try:
            with _ONE_AT_A_TIME:
                return self._redrawing()[1].shows_lanes
        except FoundryError:
            return False  # `why_not` says why

    def picture(self, step: int) -> bytes:
        """Return the state after a step as a PNG.

        Raises:
            InputError: it was not kept, and cannot be drawn.
            RecordError: the records cannot be read.
        """
        kept = kept_file(self._folder.path, frame_name(step))
        return self._drawn(step) if kept is None else kept

    def cheap(self, last: int) -> tuple[list[int], str]:
        """Return the steps whose pictures are quickly had, and why the others are not; an empty text for all."""
        kept = self.kept()
        missing = sorted({*range(last + 1)}.difference(kept))
        try:
            took_s = self._took_s(missing)
        except FoundryError as error:
            return kept, str(error)
        if took_s <= EXPORTED_S:
            return list(range(last + 1)), ""
        return kept, (
            f"to draw {len(missing)} pictures takes about {took_s:,.0f} s, which an export leaves alone: look at them "
            "with foundry view, or keep them with record.frames=true."
        )

    def _took_s(self, steps: Sequence[int]) -> float:
        """Return about how long it takes to draw these steps, seconds: by the second one, since the first reads all."""
        started = 0.0
        for step in steps[:2]:
            started = time.perf_counter()
            self._drawn(step)
        return (time.perf_counter() - started) * len(steps) if steps else 0.0

    def _drawn(self, step: int) -> bytes:
        from foundry.replay.recording import picture_of

        with _ONE_AT_A_TIME:
            recording, redrawing = self._redrawing()
            if step > recording.last:
                raise InputError(
                    f"Run '{self._folder.id}' has no whole step {step} to draw: the last is {recording.last}."
                )
            return picture_of(recording, redrawing, step)

    def _redrawing(self) -> tuple[Recording, Redrawing]:
        from foundry.replay.recording import read_recording, redrawn

        stamp = self._folder.stamp()
        if self._read is None or self._read[0] != stamp:
            recording = read_recording(self._folder, self._trusted)
            self._read = stamp, recording, redrawn(recording)
        return self._read[1:]
