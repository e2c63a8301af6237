"""The overviews of an episode in a 3D world, made again from its records."""

from __future__ import annotations

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
        episode = around.episode(recorded.episode)
        self.around = around
        self._recorded = recorded
        self._steps = msgspec.json.Decoder(CameraStep).decode_lines(recorded.steps)
        self._poses = [episode.start, *(step.pose_next for step in self._steps)]

    def draw(self, step: int) -> bytes:
        """Return the overview after a step as a PNG."""
        return png(draw_overview(self.around.scene, self.frame(step)))

    def told(self, step: int) -> Sequence[str]:
        """Return the reply that led to a step and how it was read; what was read stands in the picture."""
        if not 1 <= step <= len(self._steps):
            return ()
        record = self._steps[step - 1]
        return (f"reply ({record.outcome}): {' '.join(record.reply.split())}",)

    def frame(self, step: int) -> OverviewFrame:
        """Return what the overview after a step shows."""
        latest = self._steps[step - 1] if step else None
        return overview_after(latest, self._poses[: step + 1], self.around.settings.body.height, self.view(step))

    def view(self, step: int) -> UInt8Array:
        """Return what is seen after a step: the image that the model got then, if it is kept, else drawn again."""
        name = self._steps[step].image if step < len(self._steps) else None
        kept = None if name is None else self._recorded.kept(name)
        if kept is not None:
            return np.asarray(Image.open(io.BytesIO(kept)).convert("RGB"), np.uint8)
        pose = self._poses[step]
        return self.around.renderer().view(self.around.eye(pose), pose.yaw, pose.pitch)


def overview_after(
    latest: CameraStep | None, poses: Sequence[Pose], height_m: float, inset: UInt8Array
) -> OverviewFrame:
    """Return what the overview after a decision shows.

    Args:
        latest: the decision, or None before the first.
        poses: those that the body has stood in, the initial one first.
        height_m: the body's height.
        inset: what it sees now, (h, w, 3) RGB.
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
