"""The overviews of an episode in a 3D world, made again from its records."""

from __future__ import annotations

import io
from collections.abc import Sequence

import msgspec
import numpy as np
from PIL import Image

from foundry.errors import InputError
from foundry.records import CameraEpisode, CameraStep, Pose
from foundry.worlds.base import Recorded, Redrawing
from foundry.worlds.camera.eye.overview import OverviewFrame
from foundry.worlds.camera.eye.rendering import png
from foundry.worlds.camera.motion import feet_of
from foundry.worlds.camera.reading import describe, recorded_command
from foundry.worlds.camera.scene import UInt8Array
from foundry.worlds.camera.surroundings import Surroundings


class CameraRedrawing(Redrawing):
    """The pictures of a run: overviews with the agent, its way so far and what it sees.

    Attributes:
        around: the scene.
    """

    def __init__(self, around: Surroundings, recorded: Recorded) -> None:
        """Read the records.

        Raises:
            InputError: the run has not begun, or the scene is not the one that it was in.
        """
        if not recorded.episode:
            raise InputError("The run has not begun: it has no episode.jsonl to draw from.")
        episode = msgspec.json.decode(recorded.episode, type=CameraEpisode)
        if episode.scene_sha256 != around.scene.sha256:
            raise InputError(
                f"Scene '{around.scene.source}' is not the one of the run (SHA-256 {around.scene.sha256[:12]}, in the "
                f"records {episode.scene_sha256[:12]}): give the file back that the run was in."
            )
        self.around = around
        self._recorded = recorded
        self._steps = msgspec.json.Decoder(CameraStep).decode_lines(recorded.steps)
        self._poses = [episode.start, *(step.pose_next for step in self._steps)]

    def draw(self, step: int) -> bytes:
        """Return the overview after a step as a PNG."""
        return png(self.around.overview(self.frame(step)))

    def frame(self, step: int) -> OverviewFrame:
        """Return what the overview after a step shows."""
        record = self._steps[step - 1] if step else None
        caption = "" if record is None else describe(recorded_command(record), record)
        height_m = self.around.settings.body.height
        return overview_after(self._poses[: step + 1], height_m, caption, self.view(step))

    def view(self, step: int) -> UInt8Array:
        """Return what is seen after a step: the image that the model got then, if it is kept, else drawn again."""
        name = self._steps[step].image if step < len(self._steps) else None
        kept = None if name is None else self._recorded.kept(name)
        if kept is not None:
            return np.asarray(Image.open(io.BytesIO(kept)).convert("RGB"), np.uint8)
        pose = self._poses[step]
        return self.around.renderer().view(self.around.eye(pose), pose.yaw, pose.pitch)


def overview_after(poses: Sequence[Pose], height_m: float, caption: str, inset: UInt8Array) -> OverviewFrame:
    """Return the overview of a body of this height that has stood in these poses, the initial one first."""
    trail = feet_of(poses)
    return OverviewFrame(
        foot=trail[-1],
        yaw_deg=poses[-1].yaw,
        height_m=height_m,
        trail=trail,
        caption=f"Step {len(poses) - 1}  {caption}".strip(),
        inset=inset,
    )
