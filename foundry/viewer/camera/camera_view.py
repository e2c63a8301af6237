"""The view of a run of a 3D world: its decisions, its episode, its scene, and where its pictures show the target."""

import contextlib
import threading
from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import Any

import msgspec

from foundry.errors import InputError, RecordError
from foundry.records import NOT_JSON, CameraEpisode, CameraStep
from foundry.viewer.camera.scenes import plan_of
from foundry.viewer.camera.sights import Sights
from foundry.viewer.run_view import BINARY, JSON, OUTCOMES, UNDECIDED, Resource, RunView, parts_of

_ONE_AT_A_TIME = threading.Lock()
_OUTCOME_CODES = {name: code for code, name in enumerate(OUTCOMES)}


class _Named(msgspec.Struct):
    """The images that a decision names: its own image, and the images of a question."""

    image: str | None
    frames: tuple[str, ...] = ()


_NAMED = msgspec.json.Decoder(_Named)


class CameraView(RunView):
    """See `foundry/viewer/README.md` for the keys of results."""

    _sights: Sights | None = None

    @property
    def agents(self) -> int:
        """Number of agents."""
        return 1

    def about_world(self) -> dict[str, Any]:
        """Return the record of the episode (null before the run begins) and the folder of its images."""
        return {"episode": self.episode(), "folder": self._folder}

    @property
    def _folder(self) -> str:
        return "/".join(self.folder.path.parts[-2:])

    def scene(self) -> Resource:
        """Return the scene as GLB, empty if the world has none.

        Raises:
            InputError: the scene's file is missing, or the result cannot be stored.
        """
        from foundry.viewer.camera.scene_export import kept_scene_glb

        try:
            with _ONE_AT_A_TIME:  # two requests must not make the scene at the same time
                return Resource(kept_scene_glb(self.folder) or b"", BINARY)
        except OSError as error:
            raise InputError(f"The scene cannot be stored in the sweep's folder: {error}") from error

    def exports(self) -> Iterator[tuple[str, Resource]]:
        """Yield the 3D scene, its floor plan, and where the pictures show the target.

        The scene is empty if its files are missing.
        """
        try:
            yield "scene", self.scene()
        except InputError:
            yield "scene", Resource(b"", BINARY)
        yield "plan", self.plan()
        for chunk in range(parts_of(self.done, self.steps_per_chunk)):
            yield f"sights/{chunk}", Resource(msgspec.json.encode(self.sights(chunk)), JSON)

    def sights(self, chunk: int) -> dict[str, Any]:
        """Return, for a chunk of steps, where each picture shows the target and whether each reply claims to see it."""
        first, last = self.chunk(chunk, self.steps_per_chunk)
        episode = self._episode()
        if self._sights is None and episode is not None:
            self._sights = Sights(self.config, episode)
        shown = (
            self._sights.told(self._rows(first, last)) if self._sights else {"target": None, "why": "", "sights": []}
        )
        return {"first": first, "last": last, **shown}

    def plan(self) -> Resource:
        """Return the floor plan of the scene, without walls before the run begins. Plans with walls are stored."""
        from foundry.viewer.camera.scene_export import digest, keep

        episode = self._episode()
        if episode is None:
            return Resource(msgspec.json.encode({"walls": [], "why": ""}), JSON)
        level = (episode.scene_sha256, episode.start.z)
        file = self.folder.viewer_file(f"{digest(level, self.world.get('scene'), self.world.get('body'))}.plan.json")
        if file.is_file():
            return Resource(file.read_bytes(), JSON)
        plan = plan_of(self.config, episode)
        content = msgspec.json.encode(plan)
        if plan["walls"]:
            keep(file, content)
        return Resource(content, JSON)

    def prepare(self) -> None:
        """Store the scene and its plan in the sweep's folder."""
        with contextlib.suppress(InputError):
            self.scene()
            self.plan()

    def _episode(self) -> CameraEpisode | None:
        facts = self.episode()
        return None if facts is None else msgspec.json.decode(facts, type=CameraEpisode)

    def files(self) -> list[str]:
        """Return the files of all images that the decisions name, each once."""
        named = [_NAMED.decode(line) for line in self._lines(1, self.done)]
        paths = [path for images in named for path in (images.image, *images.frames) if path is not None]
        return [f"{self._folder}/{path}" for path in dict.fromkeys(paths)]

    def episode(self) -> msgspec.Raw | None:
        """Return the record of the episode, or None before the run begins.

        Raises:
            RecordError: the record cannot be read.
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
        """Return the decisions as they are recorded, with all keys of the world."""
        self._rows(first, last)  # raises an error if a record cannot be read
        return {"first": first, "last": last, "steps": [msgspec.Raw(line) for line in self._lines(first, last)]}

    def _lines(self, first: int, last: int) -> list[bytes]:
        return self.steps.read(first, last).splitlines()

    def marks(self, first: int, last: int) -> dict[str, list[int]]:
        """Return four marks of each decision (0 or 1): undecided, repaired, stopped by a boundary, at the goal."""
        rows = self._rows(first, last)
        return {
            "undecided": [int(row.outcome in UNDECIDED) for row in rows],
            "repaired": [int(row.outcome == "repaired") for row in rows],
            "boundary": [int(row.boundary is not None) for row in rows],
            "success": [int(row.success) for row in rows],
        }

    def by_step(self, first: int, last: int) -> dict[str, list[float | None]]:
        """Return the curves that the page plots over the steps, by their labels: one number per step."""
        every = self._rows(1, last)
        rows, way = every[first - 1 :], list(accumulate(row.travelled for row in every))[first - 1 :]
        return {
            "distance to the goal (m)": [row.distance_to_goal for row in rows],
            "path so far (m)": [*way],
            "target in view (px)": [float(row.target_visible_px) for row in rows],
            "line of sight to the target": [float(row.line_of_sight) for row in rows],
            "cells visited": [float(row.visited_cells) for row in rows],
        }

    def texts(self, first: int, last: int) -> list[tuple[int, int, str]]:
        """Return the replies."""
        return [(row.step, row.agent, row.reply) for row in self._rows(first, last)]

    def track(self, agent: int) -> dict[str, Any]:
        """Return the agent's pose before each decision and at the end, and the outcome of each decision."""
        rows = self._rows(1, self.done)
        return {
            "poses": [row.pose for row in rows] + [row.pose_next for row in rows[-1:]],
            "outcome": [_OUTCOME_CODES[row.outcome] for row in rows],
        }

    def all_tracks(self) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield agent 0, the only agent, with its track."""
        yield 0, self.track(0)

    def _rows(self, first: int, last: int) -> Sequence[CameraStep]:
        return self.read_steps(first, last, CameraStep)

    parts = {("scene", 0): scene, ("plan", 0): plan, ("sights", 1): sights}
