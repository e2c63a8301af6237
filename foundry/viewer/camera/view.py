"""A run of a 3D world: its decisions one by one, the facts of its episode, and its scene."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from typing import Any

import msgspec

from foundry.errors import InputError, RecordError
from foundry.records import NOT_JSON, CameraEpisode, CameraStep
from foundry.viewer.run_view import BINARY, OUTCOMES, UNDECIDED, Resource, RunView

_ONE_AT_A_TIME = threading.Lock()
_OUTCOME_CODES = {name: code for code, name in enumerate(OUTCOMES)}


class _Named(msgspec.Struct):
    """The images that a line names: that of the step, and further ones that went with a question."""

    image: str | None
    frames: tuple[str, ...] = ()


_NAMED = msgspec.json.Decoder(_Named)


class CameraView(RunView):
    """See `docs/viewer.md` for the keys of what is returned."""

    @property
    def agents(self) -> int:
        """Number of agents."""
        return 1

    def about_world(self) -> dict[str, Any]:
        """Return the facts of the episode, null until the run has begun, and where its images are."""
        return {"episode": self.episode(), "folder": self._folder}

    @property
    def _folder(self) -> str:
        return "/".join(self.folder.path.parts[-2:])

    def scene(self) -> Resource:
        """Return the scene as GLB, empty when its world has none. Two pages must not make it at once.

        Raises:
            InputError: its file is not there any more, or what is made of it cannot be kept.
        """
        from foundry.viewer.camera.scene_export import kept_scene_glb

        try:
            with _ONE_AT_A_TIME:
                return Resource(kept_scene_glb(self.folder) or b"", BINARY)
        except OSError as error:
            raise InputError(f"The scene cannot be kept in the sweep's folder: {error}") from error

    def exports(self) -> Iterator[tuple[str, Resource]]:
        """Yield the scene, or nothing in its place when its files are not there any more: the way is shown alone."""
        try:
            yield "scene", self.scene()
        except InputError:
            yield "scene", Resource(b"", BINARY)

    def files(self) -> list[str]:
        """Return the images that the steps name, each once."""
        named = [_NAMED.decode(line) for line in self._lines(1, self.done)]
        paths = [path for one in named for path in (one.image, *one.frames) if path is not None]
        return [f"{self._folder}/{path}" for path in dict.fromkeys(paths)]

    def episode(self) -> msgspec.Raw | None:
        """Return the facts of the episode as they are recorded, or None until the run has begun.

        Raises:
            RecordError: they cannot be read.
        """
        lines = self.folder.episode_bytes().splitlines(keepends=True)
        if not lines or not lines[0].endswith(b"\n"):
            return None
        try:
            msgspec.json.decode(lines[0], type=CameraEpisode)
        except NOT_JSON as error:
            raise RecordError(f"{self.folder.stream_path('episode')} cannot be read: {error}") from error
        return msgspec.Raw(lines[0].rstrip(b"\n"))

    def frames(self, first: int, last: int) -> dict[str, Any]:
        """Return the records as they are, with whatever keys of its own the world gives them."""
        self._rows(first, last)  # none that cannot be read goes out
        return {"first": first, "last": last, "steps": [msgspec.Raw(one) for one in self._lines(first, last)]}

    def _lines(self, first: int, last: int) -> list[bytes]:
        return self.steps.read(first, last).splitlines()

    def marks(self, first: int, last: int) -> dict[str, list[int]]:
        """Return, by step, whether it was undecided, repaired, stopped by a boundary, or at the goal."""
        rows = self._rows(first, last)
        return {
            "undecided": [int(row.outcome in UNDECIDED) for row in rows],
            "repaired": [int(row.outcome == "repaired") for row in rows],
            "boundary": [int(row.boundary is not None) for row in rows],
            "success": [int(row.success) for row in rows],
        }

    def texts(self, first: int, last: int) -> list[tuple[int, int, str]]:
        """Return the replies."""
        return [(row.step, row.agent, row.reply) for row in self._rows(first, last)]

    def track(self, agent: int) -> dict[str, Any]:
        """Return the poses and the outcomes."""
        rows = self._rows(1, self.done)
        return {
            "poses": [row.pose for row in rows] + [row.pose_next for row in rows[-1:]],
            "outcome": [_OUTCOME_CODES[row.outcome] for row in rows],
        }

    def all_tracks(self) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield the one agent's track."""
        yield 0, self.track(0)

    def _rows(self, first: int, last: int) -> Sequence[CameraStep]:
        return self.read_steps(first, last, CameraStep)

    parts = {("scene", 0): scene}
