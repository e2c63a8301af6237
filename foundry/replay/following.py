"""Where a viewer of a run is, also of one that is still going on."""

from __future__ import annotations

from collections.abc import Sequence

from foundry.replay.recording import Recording, picture_of, read_recording, redrawing_of
from foundry.storing.store import RunFolder
from foundry.worlds.base import Redrawing


class Follower:
    """Where a viewer of a run is: which step is shown, and whether the next one comes by itself.

    Attributes:
        run: the run.
        redrawing: its pictures as far as they are recorded.
        last: the last recorded step.
        step: the step that is shown.
        playing: whether the next one comes by itself.
    """

    redrawing: Redrawing

    def __init__(self, run: RunFolder, trusted: Sequence[str] = ()) -> None:
        self.run = run
        self._trusted = trusted
        self._stamp = ""
        self._read()
        self.step = 0 if run.ended else self.last
        self.playing = True

    def _read(self) -> None:
        stamp = self.run.stamp()
        if stamp == self._stamp:
            return
        self._recording: Recording = read_recording(self.run, self._trusted)
        self.redrawing, self.last, self._stamp = redrawing_of(self._recording), self._recording.last, stamp

    def tick(self) -> bool:
        """Look for new records; while playing, go to the latest step of a run that is going on, else to the next one.

        Returns:
            Whether another step is shown now.
        """
        going_on = not self.run.ended
        self._read()
        before = self.step
        if self.playing:
            self.step = self.last if going_on else min(self.step + 1, self.last)
        return self.step != before

    def go(self, step: int) -> None:
        """Show a step, or the nearest that there is, and stay there."""
        self.step, self.playing = min(max(step, 0), self.last), False

    def picture(self) -> bytes:
        """Return the state after the step that is shown as a PNG."""
        return picture_of(self._recording, self.redrawing, self.step)
