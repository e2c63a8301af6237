"""Where each picture of a 3D run shows the target, and whether the reply claims to see it."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from foundry.errors import InputError
from foundry.records import CameraEpisode, CameraStep
from foundry.viewer.camera.scenes import scene_of

if TYPE_CHECKING:
    from foundry.worlds.camera.pointing import Pointer

_ONE_AT_A_TIME = threading.Lock()
SEEN, HIDDEN, OUTSIDE = "seen", "hidden", "outside"
"""A target is visible in a picture, hidden there by another object, or outside the picture."""


class Sights:
    """Finds the target in the pictures of a run."""

    def __init__(self, run_config: Mapping[str, Any], episode: CameraEpisode) -> None:
        self._episode = episode
        self._pointer: Pointer | None = None
        self._why = ""
        try:
            self._pointer = _pointer(run_config, episode)
        except InputError as error:
            self._why = str(error)

    def told(self, rows: Iterable[CameraStep]) -> dict[str, Any]:
        """Return the target, where each decision's picture shows it, and why it cannot be marked ("" if it can).

        `foundry/viewer/README.md` lists the keys.
        """
        with _ONE_AT_A_TIME:
            return {"target": self._target(), "why": self._why, "sights": [self._sight(row) for row in rows]}

    def _target(self) -> dict[str, Any] | None:
        at = self._pointer
        return None if at is None else {"middle": _rounded(at.middle), "boxes": _rounded(at.boxes)}

    def _sight(self, row: CameraStep) -> dict[str, Any]:
        claimed = _claimed(row.reply, self._episode.target)
        if self._pointer is None or "answer" in row.command:
            return {"claimed": claimed}
        pointed = self._pointer.seen_from(row.pose)
        return {
            "claimed": claimed,
            "place": SEEN if row.target_visible_px else HIDDEN if pointed.centred else OUTSIDE,
            "boxes": _rounded(pointed.boxes),
            "spot": None if pointed.spot is None else _rounded(pointed.spot),
            "turn": round(pointed.turn, 1),
            "tilt": round(pointed.tilt, 1),
        }


def _pointer(run_config: Mapping[str, Any], episode: CameraEpisode) -> Pointer | None:
    scene = scene_of(run_config, episode.scene_sha256) if episode.target_prims else None
    if scene is None:
        return None
    from foundry.worlds.camera.camera_settings import BodySettings, EyeSettings
    from foundry.worlds.camera.pointing import Pointer
    from foundry.worlds.validation import read_settings

    eye = read_settings(EyeSettings, run_config["world"]["camera"], "world.camera")
    body = read_settings(BodySettings, run_config["world"]["body"], "world.body")
    frame = eye.width, eye.height
    return Pointer(scene, episode.target_prims, frame=frame, fov_deg=eye.fov, eye_height=body.eye_height)


def _claimed(reply: str, target: str) -> bool | None:
    """Return whether a reply claims to see the target, judged as in the analysis; None if this cannot be judged."""
    if not target or not reply.strip():
        return None
    from analysis.camera.sight_rule import claims_to_see

    return claims_to_see(reply, target)


def _rounded(values: Any) -> Any:
    return np.round(values, 4).tolist()
