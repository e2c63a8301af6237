"""The overviews of an episode in a 3D world, redrawn from its records."""

import io
from collections.abc import Sequence

import msgspec
import numpy as np
from PIL import Image

from foundry.errors import InputError
from foundry.records import CameraStep, Pose
from foundry.worlds.base import Recorded, Redrawing
from foundry.worlds.camera.eye.overview import OverviewFrame, draw_overview
from foundry.worlds.camera.eye.rendering import png
from foundry.worlds.camera.language import describe, recorded_command
from foundry.worlds.camera.loading.scene import UInt8Array
from foundry.worlds.camera.surroundings import Surroundings, feet_of


class CameraRedrawing(Redrawing):
    """The pictures of a run: overviews with the agent, its path so far and its view.

    Attributes:
        around: the scene.
    """

    def __init__(self, around: Surroundings, recorded: Recorded) -> None:
        """Read the records.

        Raises:
            InputError: the run has not begun, or the scene has changed.
        """
        if not recorded.episode:
            raise InputError("The run has not begun, so it has no episode.jsonl to draw.")
        episode = around.episode(recorded.episode)
        self.around = around
        self._recorded = recorded
        self._steps = msgspec.json.Decoder(CameraStep).decode_lines(recorded.steps)
        self._poses = [episode.start, *(step.pose_next for step in self._steps)]

    def draw(self, step: int) -> bytes:
        """Return the overview after a step as a PNG."""
        return png(draw_overview(self.around.scene, self.frame(step)))

    def told(self, step: int) -> Sequence[str]:
        """Return the reply of a step and its outcome; the picture shows the command."""
        if not 1 <= step <= len(self._steps):
            return ()
        record = self._steps[step - 1]
        return (f"reply ({record.outcome}): {' '.join(record.reply.split())}",)

    def frame(self, step: int) -> OverviewFrame:
        """Return the content of the overview after a step."""
        latest = self._steps[step - 1] if step else None
        return overview_after(latest, self._poses[: step + 1], self.around.settings.body.height, self.view(step))

    def view(self, step: int) -> UInt8Array:
        """Return the view after a step: the image sent to the model if it is stored, else a redrawn image."""
        name = self._steps[step].image if step < len(self._steps) else None
        kept = None if name is None else self._recorded.kept(name)
        if kept is not None:
            return np.asarray(Image.open(io.BytesIO(kept)).convert("RGB"), np.uint8)
        pose = self._poses[step]
        return self.around.renderer().view(self.around.eye(pose), pose.yaw, pose.pitch)


def overview_after(
    latest: CameraStep | None, poses: Sequence[Pose], height_m: float, inset: UInt8Array
) -> OverviewFrame:
    """Return the content of the overview after a decision.

    Args:
        latest: the decision, or None before the first.
        poses: poses of the body so far, the initial one first.
        height_m: the body's height.
        inset: its present view, (h, w, 3) RGB.
    """
    trail = feet_of(poses)
    caption = "" if latest is None else describe(recorded_command(latest), latest)
    return OverviewFrame(
        foot=trail[-1],
        yaw_deg=poses[-1].yaw,
        height_m=height_m,
        trail=trail,
        caption=f"Step {len(poses) - 1}  {caption}".strip(),
        inset=inset,
    )
