"""A window on a run of any form: the picture that its world draws after each step."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image

from foundry.replay.following import Follower
from foundry.replay.window import FlatPicture, Window

CAPTION_PX = 40
"""Height above the picture that is left to what is said of it."""


class PictureWindow(Window):
    """The window; the picture is as large as it can be."""

    def __init__(self, follower: Follower) -> None:
        super().__init__(follower)
        self._picture = FlatPicture()
        self._add([self._picture.actor])

    def draw(self) -> str:
        """Put the picture after the step that is shown into the window; returns its caption."""
        opened = Image.open(io.BytesIO(self._follower.picture())).convert("RGB")
        width, height = self._plotter.window_size
        scale = min(width / opened.width, (height - CAPTION_PX) / opened.height)
        size = (max(1, round(opened.width * scale)), max(1, round(opened.height * scale)))
        self._picture.show(np.asarray(opened, np.uint8), ((width - size[0]) // 2, 0), size)
        return f"Step {self._follower.step}"


WINDOW = PictureWindow
