"""The pictures of a run: those that were stored, and those that its world redraws from the records."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from foundry.errors import FoundryError, InputError
from foundry.storing.store import RunFolder, frame_name, stored_picture

if TYPE_CHECKING:
    from foundry.replay.recording import Recording
    from foundry.worlds.base import Redrawing

EXPORTED_S = 10.0
"""Maximum time for drawing the pictures of one run for an export, seconds."""
_KEPT = re.compile(r"frames/step_(\d+)\.png")
_ONE_AT_A_TIME = threading.Lock()  # most worlds cannot draw in two threads at once


class Drawing:
    """Returns pictures of a run, stored or redrawn. The run's records stay in memory until the run grows."""

    def __init__(self, folder: RunFolder, trusted: Sequence[str]) -> None:
        self._folder = folder
        self._trusted = trusted
        self._read: tuple[str, Recording, Redrawing] | None = None

    def kept(self) -> list[int]:
        """Return the steps with stored pictures, ascending."""
        names = (_KEPT.fullmatch(name) for name in self._folder.pictures())
        return sorted(int(match[1]) for match in names if match)

    def why_not(self) -> str:
        """Return the reason why no picture can be drawn, in one line; "" if pictures can be drawn."""
        try:
            self._drawn(0)
        except FoundryError as error:
            return str(error)
        return ""

    def shows_lanes(self) -> bool:
        """Return whether the page draws the decisions itself, one row per agent, so that it needs no pictures.

        Return False if the world cannot be built.
        """
        try:
            with _ONE_AT_A_TIME:
                return self._redrawing()[1].shows_lanes
        except FoundryError:
            return False  # `why_not` says why

    def picture(self, step: int) -> bytes:
        """Return a PNG of the state after a step, or raise InputError if it is neither stored nor can be drawn."""
        image = stored_picture(self._folder.path, frame_name(step))
        return self._drawn(step) if image is None else image

    def cheap(self, last: int) -> tuple[list[int], str]:
        """Return the steps whose pictures an export contains, and the reason why other steps lack pictures.

        The reason is "" if no step lacks a picture.
        """
        steps = self.kept()
        missing = sorted({*range(last + 1)}.difference(steps))
        try:
            took_s = self._took_s(missing)
        except FoundryError as error:
            return steps, str(error)
        if took_s <= EXPORTED_S:
            return list(range(last + 1)), ""
        return steps, (
            f"to draw {len(missing)} pictures takes about {took_s:,.0f} s, which is too long for an export. Use "
            "foundry view to see them, or store them during the run with record.frames=true."
        )

    def _took_s(self, steps: Sequence[int]) -> float:
        """Estimate the seconds to draw pictures of these steps, from the second picture; the first also loads data."""
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
                    f"Run '{self._folder.id}' has no complete step {step} to draw. The last one is {recording.last}."
                )
            return picture_of(recording, redrawing, step)

    def _redrawing(self) -> tuple[Recording, Redrawing]:
        from foundry.replay.recording import read_recording, redrawn

        stamp = self._folder.stamp()
        if self._read is None or self._read[0] != stamp:
            recording = read_recording(self._folder, self._trusted)
            self._read = stamp, recording, redrawn(recording)
        return self._read[1:]
